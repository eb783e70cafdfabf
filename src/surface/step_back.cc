// Moves of a surface's vertices, shortened where they would make it cross itself.
#include "surface/step_back.h"

#include "core/parallel.h"
#include "geometry/orientation.h"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace tetrec {
namespace {

constexpr int kHalvings = 1;     // of a vertex's move before it is undone
constexpr int kMaxRounds = 100;  // each takes vertices back, so a few suffice

int SharedVertices(const glm::uvec3& a, const glm::uvec3& b) {
  int shared = 0;
  for (int i = 0; i < 3; ++i) shared += a[i] == b.x || a[i] == b.y || a[i] == b.z;
  return shared;
}

class Crossings {
 public:
  explicit Crossings(const TriangleMesh& mesh) : mesh_(mesh) {
    for (uint32_t t = 0; t < mesh.triangles.size(); ++t) order_.push_back(t);
    std::sort(order_.begin(), order_.end(),
              [&](uint32_t a, uint32_t b) { return Low(a).x < Low(b).x; });
    for (const uint32_t t : order_) {
      lows_.push_back(Low(t));
      highs_.push_back(High(t));
    }
  }

  // Whether each triangle crosses another.
  std::vector<uint8_t> Find() const {
    std::vector<std::vector<uint32_t>> found(order_.size());
    ParallelFor(order_.size(), 256, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) found[i] = CrossedBy(i);
    });
    std::vector<uint8_t> crosses(order_.size(), 0);
    for (size_t i = 0; i < found.size(); ++i) {
      for (const uint32_t other : found[i]) crosses[order_[i]] = crosses[other] = 1;
    }
    return crosses;
  }

 private:
  glm::vec3 At(uint32_t t, int k) const { return mesh_.positions[mesh_.triangles[t][k]]; }
  glm::vec3 Low(uint32_t t) const { return glm::min(At(t, 0), glm::min(At(t, 1), At(t, 2))); }
  glm::vec3 High(uint32_t t) const { return glm::max(At(t, 0), glm::max(At(t, 1), At(t, 2))); }

  // Among the triangles that come later in order, which begin farther along x.
  std::vector<uint32_t> CrossedBy(size_t i) const {
    const uint32_t a = order_[i];
    const glm::vec3 low = lows_[i], high = highs_[i];
    std::vector<uint32_t> crossed;
    for (size_t j = i + 1; j < order_.size() && lows_[j].x <= high.x; ++j) {
      const glm::vec3 low_b = lows_[j], high_b = highs_[j];
      if (low_b.y > high.y || high_b.y < low.y || low_b.z > high.z || high_b.z < low.z) continue;
      const uint32_t b = order_[j];
      if (SharedVertices(mesh_.triangles[a], mesh_.triangles[b]) >= 2) continue;
      if (AnEdgePierces(a, b) || AnEdgePierces(b, a)) crossed.push_back(b);
    }
    return crossed;
  }

  // Whether an edge of `a` that has no vertex in common with `b` goes through it.
  bool AnEdgePierces(uint32_t a, uint32_t b) const {
    const glm::uvec3& t = mesh_.triangles[b];
    for (int k = 0; k < 3; ++k) {
      const uint32_t p = mesh_.triangles[a][k], q = mesh_.triangles[a][(k + 1) % 3];
      if (p == t.x || p == t.y || p == t.z || q == t.x || q == t.y || q == t.z) continue;
      if (Sign(t.x, t.y, t.z, p) * Sign(t.x, t.y, t.z, q) > 0) continue;
      const int x = Sign(p, q, t.x, t.y), y = Sign(p, q, t.y, t.z), z = Sign(p, q, t.z, t.x);
      if ((x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0)) return true;
    }
    return false;
  }
  int Sign(uint32_t a, uint32_t b, uint32_t c, uint32_t d) const {
    const auto& p = mesh_.positions;
    return Orientation(p[a], p[b], p[c], p[d]);
  }

  const TriangleMesh& mesh_;
  std::vector<uint32_t> order_;          // by lowest x
  std::vector<glm::vec3> lows_, highs_;  // of the triangles' boxes, in this order
};

}  // namespace

TriangleMesh StepBackFromCrossings(const TriangleMesh& start, TriangleMesh moved) {
  std::vector<int> halvings(start.positions.size(), 0);
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<uint8_t> crosses = Crossings(moved).Find();
    std::vector<uint8_t> goes_back(start.positions.size(), 0);
    for (size_t t = 0; t < crosses.size(); ++t) {
      for (int k = 0; k < 3 && crosses[t]; ++k) goes_back[moved.triangles[t][k]] = 1;
    }
    bool changed = false;
    for (size_t v = 0; v < goes_back.size(); ++v) {
      if (!goes_back[v] || moved.positions[v] == start.positions[v]) continue;
      const bool half = ++halvings[v] <= kHalvings;
      moved.positions[v] =
          half ? 0.5f * (moved.positions[v] + start.positions[v]) : start.positions[v];
      changed = true;
    }
    if (!changed) break;
  }
  return moved;
}

}  // namespace tetrec
