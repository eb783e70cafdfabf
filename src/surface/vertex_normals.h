// Normals of surfaces.
#pragma once

#include "mesh/triangle_mesh.h"

#include <glm/glm.hpp>

#include <vector>

namespace tetrec {

// The triangle's normal times twice its area.
inline glm::dvec3 DoubleAreaNormal(const TriangleMesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a(mesh.positions[t.x]);
  return glm::cross(glm::dvec3(mesh.positions[t.y]) - a, glm::dvec3(mesh.positions[t.z]) - a);
}

// (V) Unit normals of vertices: the mean of their triangles by area, then `rounds` times the mean
// with the neighbours'. 0 where there is none.
std::vector<glm::dvec3> SmoothNormals(const TriangleMesh& mesh, int rounds);

}  // namespace tetrec
