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

// A level set with colours by which its vertices can be recognised.
inline TriangleMesh Sphere(double radius, const glm::dvec3& center, bool inward = false) {
  static const TetMesh mesh = JitteredBox(14);
  static const LevelSet set = MarchTetrahedra(mesh, Sampled(mesh, Ball), 0);
  TriangleMesh sphere = AsTriangles(set);
  for (glm::vec3& p : sphere.positions) p = glm::vec3(radius * glm::dvec3(p) + center);
  if (inward) {
    for (glm::uvec3& t : sphere.triangles) std::swap(t.y, t.z);
  }
  for (size_t v = 0; v < sphere.positions.size(); ++v) {
    sphere.colors_srgb.push_back({uint8_t(v), uint8_t(v >> 8), 7});
  }
  return sphere;
}

}  // namespace tetrec
