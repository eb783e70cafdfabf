// Fields of known shape on jittered Delaunay meshes.
#pragma once

#include "mesh/delaunay.h"
#include "start/start_points.h"
#include "surface/marching_tetrahedra.h"

#include <cmath>
#include <functional>
#include <vector>

namespace tetrec {

inline TetMesh JitteredBox(int cells, double half_side = 1.5) {
  const Bounds3 box{glm::dvec3(-half_side), glm::dvec3(half_side)};
  return BuildDelaunay(StartFromGrid(box, cells, 1).positions).mesh;
}

inline std::vector<float> Sampled(const TetMesh& mesh,
                                  const std::function<double(const glm::dvec3&)>& function) {
  std::vector<float> values;
  for (const glm::vec3& p : mesh.positions) values.push_back(float(function(glm::dvec3(p))));
  return values;
}

// Level functions of shapes, positive inside.
inline double Ball(const glm::dvec3& p) { return 1 - glm::length(p); }
inline double Torus(const glm::dvec3& p) {
  return 0.4 - std::hypot(std::hypot(p.x, p.y) - 0.9, p.z);
}

inline TriangleMesh AsTriangles(const LevelSet& set) { return {set.positions, {}, set.triangles}; }

}  // namespace tetrec
