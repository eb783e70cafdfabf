// Search for the tet that contains a point.
#include "mesh/locate.h"

#include "core/parallel.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace tetrec {
namespace {

// Six times the signed volume of the tet with its vertex `face` replaced by the point. Negative if
// the point is beyond that face.
double Side(const TetMesh& mesh, uint32_t tet, int face, const glm::dvec3& point) {
  glm::dvec3 p[4];
  for (int i = 0; i < 4; ++i) {
    p[i] = i == face ? point : glm::dvec3(mesh.positions[mesh.tets[tet][i]]);
  }
  return glm::dot(p[3] - p[0], glm::cross(p[1] - p[0], p[2] - p[0]));
}

// The face that the point is farthest beyond, or -1 if the tet contains the point.
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

bool BoxContains(const TetMesh& mesh, uint32_t tet, const glm::dvec3& point) {
  const glm::uvec4& ids = mesh.tets[tet];
  glm::vec3 low = mesh.positions[ids[0]], high = low;
  for (int i = 1; i < 4; ++i) {
    low = glm::min(low, mesh.positions[ids[i]]);
    high = glm::max(high, mesh.positions[ids[i]]);
  }
  return glm::all(glm::lessThanEqual(glm::dvec3(low), point)) &&
         glm::all(glm::lessThanEqual(point, glm::dvec3(high)));
}

// The first tet that contains the point, found by trying all of them.
uint32_t ScanForTet(const TetMesh& mesh, const glm::dvec3& point) {
  std::atomic<uint32_t> found = kNoTet;
  ParallelFor(mesh.tets.size(), 1 << 14, [&](size_t begin, size_t end) {
    for (uint32_t t = uint32_t(begin); t < end && t < found.load(std::memory_order_relaxed); ++t) {
      if (!BoxContains(mesh, t, point) || FaceBeyond(mesh, t, point) >= 0) continue;
      uint32_t before = found;
      while (t < before && !found.compare_exchange_weak(before, t)) {
      }
    }
  });
  return found;
}

}  // namespace

uint32_t FindTet(const TetMesh& mesh, const glm::dvec3& point, uint32_t start, bool is_convex) {
  uint32_t tet = start < mesh.tets.size() ? start : 0;
  const size_t most = 100 + size_t(20 * std::cbrt(double(mesh.tets.size())));
  for (size_t step = 0; step < most; ++step) {
    const int face = FaceBeyond(mesh, tet, point);
    if (face < 0) return tet;
    const uint32_t next = mesh.neighbors[tet][face];
    if (next == kNoTet) return is_convex ? kNoTet : ScanForTet(mesh, point);
    tet = next;
  }
  return ScanForTet(mesh, point);  // the walk circles, as it may where the mesh is not Delaunay
}

glm::dvec3 Centroid(const TetMesh& mesh, const glm::uvec4& tet) {
  glm::dvec3 sum(0.0);
  for (int i = 0; i < 4; ++i) sum += glm::dvec3(mesh.positions[tet[i]]);
  return 0.25 * sum;
}

glm::dvec4 WeightsInTet(const TetMesh& mesh, uint32_t tet, const glm::dvec3& point) {
  glm::dvec4 weights;
  for (int i = 0; i < 4; ++i) weights[i] = std::max(0.0, Side(mesh, tet, i, point));
  const double sum = weights[0] + weights[1] + weights[2] + weights[3];
  return sum > 0 ? weights / sum : glm::dvec4(0.25);
}

}  // namespace tetrec
