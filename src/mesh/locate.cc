// Which tet holds a point.
#include "mesh/locate.h"

namespace tetrec {
namespace {

// Six times the signed volume of the tet with its vertex `face` replaced by the point: negative
// where the point lies beyond that face.
double Side(const TetMesh& mesh, uint32_t tet, int face, const glm::dvec3& point) {
  glm::dvec3 p[4];
  for (int i = 0; i < 4; ++i) {
    p[i] = i == face ? point : glm::dvec3(mesh.positions[mesh.tets[tet][i]]);
  }
  return glm::dot(p[3] - p[0], glm::cross(p[1] - p[0], p[2] - p[0]));
}

// The face that the point lies farthest beyond; -1 where the tet holds it.
int FaceBeyond(const TetMesh& mesh, uint32_t tet, const glm::dvec3& point) {
  int face = -1;
  double least = 0.0;
  for (int i = 0; i < 4; ++i) {
    const double side = Side(mesh, tet, i, point);
    if (side < least) {
      least = side;
      face = i;
    }
  }
  return face;
}

}  // namespace

uint32_t FindTet(const TetMesh& mesh, const glm::dvec3& point, uint32_t start) {
  uint32_t tet = start < mesh.tets.size() ? start : 0;
  for (size_t step = 0; step < mesh.tets.size(); ++step) {
    const int face = FaceBeyond(mesh, tet, point);
    if (face < 0) return tet;
    const uint32_t next = mesh.neighbors[tet][face];
    if (next == kNoTet) return kNoTet;  // beyond a face of a convex hull
    tet = next;
  }
  // The walk went in circles by rounding.
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    if (FaceBeyond(mesh, t, point) < 0) return t;
  }
  return kNoTet;
}

}  // namespace tetrec
