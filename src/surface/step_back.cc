// Moves of a surface's vertices, shortened where they would make it cross itself.
#include "surface/step_back.h"

#include "core/parallel.h"
#include "core/stop_request.h"
#include "geometry/orientation.h"
#include "surface/trained_views.h"

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

constexpr int kHalvings = 1;          // of a vertex's move before it is undone
constexpr size_t kFewTriangles = 48;  // are compared with each other rather than split up
constexpr int kMaxRounds = 100;       // each takes vertices back, so a few suffice

int SharedVertices(const glm::uvec3& a, const glm::uvec3& b) {
  int shared = 0;
  for (int i = 0; i < 3; ++i) shared += a[i] == b.x || a[i] == b.y || a[i] == b.z;
  return shared;
}

// Only triangles whose boxes meet can cross. They are found by halving space where it contains many
// triangles, however much these differ in size.
class Crossings {
 public:
  explicit Crossings(const TriangleMesh& mesh) : mesh_(mesh) {
    boxes_.reserve(mesh.triangles.size());
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::vec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
      boxes_.push_back({glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))});
    }
  }

  // Whether each triangle crosses another, among the pairs in which one is `of_interest`.
  std::vector<uint8_t> Find(const std::vector<uint8_t>& of_interest) const {
    std::vector<uint8_t> crosses(mesh_.triangles.size(), 0);
    std::vector<Part> parts(1);
    parts[0].triangles.resize(crosses.size());
    std::iota(parts[0].triangles.begin(), parts[0].triangles.end(), 0u);
    while (!parts.empty()) {
      ThrowIfStopRequested(kAfterASurfaceStop);
      std::vector<Part> halves(2 * parts.size());
      ParallelFor(parts.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
          const Part part = std::exchange(parts[i], {});
          if (!Halve(part, of_interest, halves[2 * i], halves[2 * i + 1])) {
            MarkCrossings(part, of_interest, crosses);
          }
        }
      });
      std::erase_if(halves, [](const Part& half) { return half.triangles.size() < 2; });
      parts = std::move(halves);
    }
    return crosses;
  }

 private:
  struct Box {
    glm::vec3 low, high;
  };
  // A part of space, without its upper faces, and the triangles whose boxes meet it.
  struct Part {
    Box space{glm::vec3(-std::numeric_limits<float>::infinity()),
              glm::vec3(std::numeric_limits<float>::infinity())};
    std::vector<uint32_t> triangles;
  };

  glm::vec3 TwiceCenter(uint32_t triangle) const {
    return boxes_[triangle].low + boxes_[triangle].high;
  }

  // False if the part has few triangles, or most are in both halves. A half without a triangle of
  // interest is left empty.
  bool Halve(const Part& part, const std::vector<uint8_t>& of_interest, Part& lower,
             Part& upper) const {
    const size_t count = part.triangles.size();
    if (count <= kFewTriangles) return false;
    Box centers{glm::vec3(std::numeric_limits<float>::infinity()),
                glm::vec3(-std::numeric_limits<float>::infinity())};
    glm::dvec3 sum(0.0);
    for (const uint32_t t : part.triangles) {
      const glm::vec3 center = TwiceCenter(t);
      centers = {glm::min(centers.low, center), glm::max(centers.high, center)};
      sum += glm::dvec3(center);
    }
    const glm::vec3 size = centers.high - centers.low;
    const int axis = size.x >= std::max(size.y, size.z) ? 0 : size.y >= size.z ? 1 : 2;
    const float middle = float(0.5 * sum[axis] / double(count));
    lower.space = upper.space = part.space;
    lower.space.high[axis] = upper.space.low[axis] = middle;
    lower.triangles.reserve(count);
    upper.triangles.reserve(count);
    bool has_lower = false, has_upper = false;
    for (const uint32_t t : part.triangles) {
      if (boxes_[t].low[axis] < middle) {
        lower.triangles.push_back(t);
        has_lower = has_lower || of_interest[t];
      }
      if (boxes_[t].high[axis] >= middle) {
        upper.triangles.push_back(t);
        has_upper = has_upper || of_interest[t];
      }
    }
    const size_t larger = std::max(lower.triangles.size(), upper.triangles.size());
    const bool separates =
        larger < count && 2 * (lower.triangles.size() + upper.triangles.size()) < 3 * count;
    if (!separates || !has_lower) lower.triangles.clear();
    if (!separates || !has_upper) upper.triangles.clear();
    return separates;
  }

  // Compares the triangles of a part. Other parts may mark the same triangles at the same time.
  void MarkCrossings(const Part& part, const std::vector<uint8_t>& of_interest,
                     std::vector<uint8_t>& crosses) const {
    const auto mark = [&](uint32_t triangle) {
      return std::atomic_ref<uint8_t>(crosses[triangle]);
    };
    for (size_t i = 0; i < part.triangles.size(); ++i) {
      for (size_t j = i + 1; j < part.triangles.size(); ++j) {
        const uint32_t a = part.triangles[i], b = part.triangles[j];
        if (!of_interest[a] && !of_interest[b]) continue;
        if (!MeetFirstIn(part.space, boxes_[a], boxes_[b])) continue;
        if (mark(a).load(std::memory_order_relaxed) && mark(b).load(std::memory_order_relaxed)) {
          continue;
        }
        if (!Cross(a, b)) continue;
        mark(a).store(1, std::memory_order_relaxed);
        mark(b).store(1, std::memory_order_relaxed);
      }
    }
  }

  // True if two boxes meet and the space contains the low corner of their intersection, which is in
  // one part only: each pair is compared once.
  static bool MeetFirstIn(const Box& space, const Box& a, const Box& b) {
    if (glm::any(glm::greaterThan(a.low, b.high)) || glm::any(glm::greaterThan(b.low, a.high))) {
      return false;
    }
    const glm::vec3 corner = glm::max(a.low, b.low);
    return glm::all(glm::lessThanEqual(space.low, corner)) &&
           glm::all(glm::lessThan(corner, space.high));
  }

  // False for triangles with an edge in common, which cannot cross unless they are folded flat.
  bool Cross(uint32_t a, uint32_t b) const {
    if (SharedVertices(mesh_.triangles[a], mesh_.triangles[b]) >= 2) return false;
    return AnEdgePierces(a, b) || AnEdgePierces(b, a);
  }

  // Whether an edge of `a` that has no vertex in common with `b` goes through it.
  bool AnEdgePierces(uint32_t a, uint32_t b) const {
    const glm::uvec3& corners = mesh_.triangles[a];
    const glm::uvec3& t = mesh_.triangles[b];
    bool shared[3];
    int side[3] = {0, 0, 0};
    for (int k = 0; k < 3; ++k) {
      shared[k] = corners[k] == t.x || corners[k] == t.y || corners[k] == t.z;
      if (!shared[k]) side[k] = Sign(t.x, t.y, t.z, corners[k]);
    }
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if (shared[k] || shared[next] || side[k] * side[next] > 0) continue;
      const uint32_t p = corners[k], q = corners[next];
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
  std::vector<Box> boxes_;  // of the triangles
};

// Triangles with such a vertex.
std::vector<uint8_t> TrianglesAt(const std::vector<uint8_t>& vertices, const TriangleMesh& mesh) {
  std::vector<uint8_t> triangles;
  for (const glm::uvec3& t : mesh.triangles) {
    triangles.push_back(vertices[t.x] | vertices[t.y] | vertices[t.z]);
  }
  return triangles;
}

}  // namespace

TriangleMesh StepBackFromCrossings(const TriangleMesh& start, TriangleMesh moved) {
  std::vector<int> halvings(start.positions.size(), 0);
  std::vector<uint8_t> changed(start.positions.size());
  for (size_t v = 0; v < changed.size(); ++v) {
    changed[v] = moved.positions[v] != start.positions[v];
  }
  for (int round = 0; round < kMaxRounds; ++round) {
    const std::vector<uint8_t> crosses = Crossings(moved).Find(TrianglesAt(changed, moved));
    std::vector<uint8_t> goes_back(start.positions.size(), 0);
    for (size_t t = 0; t < crosses.size(); ++t) {
      for (int k = 0; k < 3 && crosses[t]; ++k) goes_back[moved.triangles[t][k]] = 1;
    }
    for (size_t v = 0; v < goes_back.size(); ++v) {
      changed[v] = goes_back[v] && moved.positions[v] != start.positions[v];
      if (!changed[v]) continue;
      const bool half = ++halvings[v] <= kHalvings;
      moved.positions[v] =
          half ? 0.5f * (moved.positions[v] + start.positions[v]) : start.positions[v];
    }
    if (std::none_of(changed.begin(), changed.end(), [](uint8_t c) { return c != 0; })) break;
  }
  return moved;
}

}  // namespace tetrec
