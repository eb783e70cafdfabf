// Moves of a surface's vertices, shortened where they would make it cross itself.
#include "surface/step_back.h"

#include "core/parallel.h"
#include "geometry/orientation.h"

#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

#include <algorithm>
#include <atomic>
#include <compare>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {
namespace {

constexpr int kHalvings = 1;          // of a vertex's move before it is undone
constexpr uint32_t kMostCells = 128;  // along each axis
constexpr size_t kCellsPerTask = 1024;
constexpr int kMaxRounds = 100;  // each takes vertices back, so a few suffice

int SharedVertices(const glm::uvec3& a, const glm::uvec3& b) {
  int shared = 0;
  for (int i = 0; i < 3; ++i) shared += a[i] == b.x || a[i] == b.y || a[i] == b.z;
  return shared;
}

// A grid of cells as wide as most triangles are: only triangles whose boxes meet in a cell can
// cross.
class Crossings {
 public:
  explicit Crossings(const TriangleMesh& mesh) : mesh_(mesh) {
    if (mesh.triangles.empty()) return;
    double widths = 0;
    for (const glm::uvec3& t : mesh.triangles) {
      const glm::vec3 &a = mesh.positions[t.x], &b = mesh.positions[t.y], &c = mesh.positions[t.z];
      boxes_.push_back({glm::min(a, glm::min(b, c)), glm::max(a, glm::max(b, c))});
      const glm::vec3 size = boxes_.back().high - boxes_.back().low;
      widths += std::max({size.x, size.y, size.z});
    }
    low_ = boxes_[0].low;
    glm::vec3 high = boxes_[0].high;
    for (const Box& box : boxes_) low_ = glm::min(low_, box.low), high = glm::max(high, box.high);
    const glm::vec3 size = high - low_;
    const float mean = float(widths / double(mesh.triangles.size()));
    cell_size_ =
        std::max({2 * mean, size.x / kMostCells, size.y / kMostCells, size.z / kMostCells});
  }

  // Whether each triangle crosses another, among the pairs in which one is `of_interest`.
  std::vector<uint8_t> Find(const std::vector<uint8_t>& of_interest) const {
    std::vector<uint8_t> crosses(mesh_.triangles.size(), 0);
    if (crosses.empty() || !(cell_size_ > 0)) return crosses;
    const std::vector<Entry> entries = SortedEntries(of_interest);
    const std::vector<size_t> cells = BeginningsOf(entries);
    ParallelFor(cells.size() - 1, kCellsPerTask, [&](size_t from, size_t to) {
      for (size_t i = from; i < to; ++i) {
        MarkCrossings(std::span(entries).subspan(cells[i], cells[i + 1] - cells[i]), of_interest,
                      crosses);
      }
    });
    return crosses;
  }

 private:
  struct Box {
    glm::vec3 low, high;
  };
  struct Entry {
    uint32_t cell, triangle;
    auto operator<=>(const Entry&) const = default;
  };

  // The first entries of all cells, and the end of the last one.
  static std::vector<size_t> BeginningsOf(const std::vector<Entry>& entries) {
    std::vector<size_t> beginnings;
    for (size_t i = 0; i < entries.size(); ++i) {
      if (i == 0 || entries[i].cell != entries[i - 1].cell) beginnings.push_back(i);
    }
    beginnings.push_back(entries.size());
    return beginnings;
  }

  // Compares the triangles of one cell. Other cells may mark the same triangles at the same time.
  void MarkCrossings(std::span<const Entry> cell, const std::vector<uint8_t>& of_interest,
                     std::vector<uint8_t>& crosses) const {
    const auto mark = [&](uint32_t triangle) {
      return std::atomic_ref<uint8_t>(crosses[triangle]);
    };
    for (size_t i = 0; i < cell.size(); ++i) {
      for (size_t j = i + 1; j < cell.size(); ++j) {
        const uint32_t a = cell[i].triangle, b = cell[j].triangle;
        if (!of_interest[a] && !of_interest[b]) continue;
        if (!MeetFirstIn(cell[i].cell, boxes_[a], boxes_[b])) continue;
        if (mark(a).load(std::memory_order_relaxed) && mark(b).load(std::memory_order_relaxed)) {
          continue;
        }
        if (!Cross(a, b)) continue;
        mark(a).store(1, std::memory_order_relaxed);
        mark(b).store(1, std::memory_order_relaxed);
      }
    }
  }

  // True if two boxes meet and this cell contains the low corner of their intersection, which is in
  // one cell only: each pair is compared once.
  bool MeetFirstIn(uint32_t cell, const Box& a, const Box& b) const {
    if (glm::any(glm::greaterThan(a.low, b.high)) || glm::any(glm::greaterThan(b.low, a.high))) {
      return false;
    }
    return cell == NumberOf(CellOf(glm::max(a.low, b.low)));
  }

  // Calls body(cell) for the cells that a triangle's box meets.
  template <class Body>
  void ForEachCell(uint32_t t, const Body& body) const {
    const glm::uvec3 from = CellOf(boxes_[t].low), to = CellOf(boxes_[t].high);
    for (uint32_t z = from.z; z <= to.z; ++z) {
      for (uint32_t y = from.y; y <= to.y; ++y) {
        for (uint32_t x = from.x; x <= to.x; ++x) body(NumberOf({x, y, z}));
      }
    }
  }

  // One for each cell that a triangle's box meets, if a triangle of interest meets it, too.
  std::vector<Entry> SortedEntries(const std::vector<uint8_t>& of_interest) const {
    std::vector<bool> looked_at(size_t{kMostCells} * kMostCells * kMostCells, false);
    for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (of_interest[t]) ForEachCell(t, [&](uint32_t cell) { looked_at[cell] = true; });
    }
    std::vector<Entry> entries;
    for (uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      ForEachCell(t, [&](uint32_t cell) {
        if (looked_at[cell]) entries.push_back({cell, t});
      });
    }
    std::sort(entries.begin(), entries.end());
    return entries;
  }

  glm::uvec3 CellOf(const glm::vec3& place) const {
    return glm::min(glm::uvec3((place - low_) / cell_size_), glm::uvec3(kMostCells - 1));
  }
  static uint32_t NumberOf(const glm::uvec3& cell) {
    return (cell.z * kMostCells + cell.y) * kMostCells + cell.x;
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
  glm::vec3 low_{0};
  float cell_size_ = 0;
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
