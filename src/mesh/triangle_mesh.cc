// Triangle meshes with vertex colours.
#include "mesh/triangle_mesh.h"

namespace tetrec {

TriangleMesh Transformed(TriangleMesh mesh, const Similarity3& b_from_a) {
  for (glm::vec3& p : mesh.positions) p = glm::vec3(b_from_a * glm::dvec3(p));
  return mesh;
}

}  // namespace tetrec
