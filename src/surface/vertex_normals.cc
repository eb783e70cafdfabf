// Normals of surfaces.
#include "surface/vertex_normals.h"

namespace tetrec {
namespace {

void Normalize(std::vector<glm::dvec3>& normals) {
  for (glm::dvec3& normal : normals) {
    const double length = glm::length(normal);
    if (length > 0) normal /= length;
  }
}

}  // namespace

std::vector<glm::dvec3> SmoothNormals(const TriangleMesh& mesh, int rounds) {
  std::vector<glm::dvec3> normals(mesh.positions.size(), glm::dvec3(0.0));
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 normal = DoubleAreaNormal(mesh, t);
    for (int k = 0; k < 3; ++k) normals[t[k]] += normal;
  }
  Normalize(normals);
  for (int round = 0; round < rounds; ++round) {
    std::vector<glm::dvec3> sums(normals.size(), glm::dvec3(0.0));
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::dvec3 sum = normals[t.x] + normals[t.y] + normals[t.z];
      for (int k = 0; k < 3; ++k) sums[t[k]] += sum;
    }
    Normalize(sums);
    normals = std::move(sums);
  }
  return normals;
}

}  // namespace tetrec
