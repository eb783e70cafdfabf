// Triangle meshes with vertex colours.
#include "mesh/triangle_mesh.h"

namespace tetrec {

TriangleMesh Transformed(TriangleMesh mesh, const Similarity3& b_from_a) {
  for (glm::vec3& p : mesh.positions) p = glm::vec3(b_from_a * glm::dvec3(p));
  return mesh;
}

TriangleMesh Joined(TriangleMesh a, const TriangleMesh& b) {
  const uint32_t first_of_b = uint32_t(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  a.colors_srgb.insert(a.colors_srgb.end(), b.colors_srgb.begin(), b.colors_srgb.end());
  for (const glm::uvec3& t : b.triangles) a.triangles.push_back(t + first_of_b);
  a.corner_coordinates.clear();
  return a;
}

}  // namespace tetrec
