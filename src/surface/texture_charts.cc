// Charts grow over triangles that face the same way, without overlap in their plane.
#include "surface/texture_charts.h"

#include "surface/side_of_line.h"
#include "surface/vertex_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>
#include <unordered_set>

namespace tetrec {
namespace {

// Cosines between the chart's normal and the smoothed normals of its triangles, by which charts
// end at edges of the shape, and their own normals, by which no triangle is squeezed.
constexpr double kAgree = 0.5, kStandsUp = 0.15;

// (M) Per triangle and edge (from corner k to k + 1) the triangle behind it, or its own id.
std::vector<glm::uvec3> NeighborsOf(const TriangleMesh& mesh) {
  struct Side {
    uint64_t edge;
    uint32_t triangle;
    int k;
  };
  std::vector<Side> sides;
  std::vector<glm::uvec3> neighbors;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    neighbors.emplace_back(t);
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = mesh.triangles[t][k], b = mesh.triangles[t][(k + 1) % 3];
      sides.push_back({uint64_t{std::min(a, b)} << 32 | std::max(a, b), t, k});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return std::pair(a.edge, a.triangle) < std::pair(b.edge, b.triangle);
  });
  for (size_t s = 0; s + 1 < sides.size(); ++s) {
    if (sides[s].edge != sides[s + 1].edge) continue;
    neighbors[sides[s].triangle][sides[s].k] = sides[s + 1].triangle;
    neighbors[sides[s + 1].triangle][sides[s + 1].k] = sides[s].triangle;
  }
  return neighbors;
}

using Corners = std::array<glm::dvec2, 3>;

double Area(const Corners& t) { return 0.5 * SideOfLine(t[0], t[1], t[2]); }

// An edge of a counter-clockwise triangle has all of the other one on its outside.
bool IsSeparatedByEdge(const Corners& t, const Corners& other) {
  for (size_t k = 0; k < 3; ++k) {
    if (std::all_of(other.begin(), other.end(), [&](const glm::dvec2& p) {
          return SideOfLine(t[k], t[(k + 1) % 3], p) <= 0;
        })) {
      return true;
    }
  }
  return false;
}

bool Overlap(const Corners& a, const Corners& b) {
  return !IsSeparatedByEdge(a, b) && !IsSeparatedByEdge(b, a);
}

// Triangles in a plane, found by the squares of a grid that their boxes touch.
class PlaneTriangles {
 public:
  explicit PlaneTriangles(double square) : square_(square) {}

  bool IsFree(const Corners& triangle) const {
    bool free = true;
    ForSquares(triangle, [&](uint64_t key) {
      const auto found = free ? squares_.find(key) : squares_.end();
      if (found == squares_.end()) return;
      for (const uint32_t other : found->second) {
        free = free && !Overlap(triangle, triangles_[other]);
      }
    });
    return free;
  }
  void Add(const Corners& triangle) {
    ForSquares(triangle,
               [&](uint64_t key) { squares_[key].push_back(uint32_t(triangles_.size())); });
    triangles_.push_back(triangle);
  }

 private:
  template <class Visit>
  void ForSquares(const Corners& t, const Visit& visit) const {
    const glm::dvec2 low = glm::floor(glm::min(t[0], glm::min(t[1], t[2])) / square_),
                     high = glm::floor(glm::max(t[0], glm::max(t[1], t[2])) / square_);
    for (auto y = int64_t(low.y); y <= int64_t(high.y); ++y) {
      for (auto x = int64_t(low.x); x <= int64_t(high.x); ++x) {
        visit(uint64_t(uint32_t(x)) << 32 | uint32_t(y));
      }
    }
  }

  double square_;
  std::vector<Corners> triangles_;
  std::unordered_map<uint64_t, std::vector<uint32_t>> squares_;
};

class ChartCutter {
 public:
  explicit ChartCutter(const TriangleMesh& mesh)
      : mesh_(mesh), neighbors_(NeighborsOf(mesh)), chart_(mesh.triangles.size(), kNone) {
    const std::vector<glm::dvec3> vertex_normals = SmoothNormals(mesh, 5);
    double edges = 0;
    for (const glm::uvec3& t : mesh.triangles) {
      areas_.push_back(DoubleAreaNormal(mesh, t));
      smooth_.push_back(vertex_normals[t.x] + vertex_normals[t.y] + vertex_normals[t.z]);
      if (const double length = glm::length(smooth_.back()); length > 0) smooth_.back() /= length;
      edges += std::sqrt(glm::length(areas_.back()));
    }
    // Of some size even where all triangles are flat, so that the grid stays finite.
    square_ =
        std::max(2 * edges / double(std::max<size_t>(1, mesh.triangles.size())), Extent() / 1e4);
  }

  std::vector<TextureChart> Cut() {
    std::vector<uint32_t> seeds(mesh_.triangles.size());
    std::iota(seeds.begin(), seeds.end(), 0u);
    std::stable_sort(seeds.begin(), seeds.end(), [&](uint32_t a, uint32_t b) {
      return glm::length(areas_[a]) > glm::length(areas_[b]);
    });
    std::vector<TextureChart> charts;
    for (const uint32_t seed : seeds) {
      if (chart_[seed] == kNone) charts.push_back(Grow(seed, uint32_t(charts.size())));
    }
    return charts;
  }

 private:
  static constexpr uint32_t kNone = 0xFFFFFFFFu;

  double Extent() const {
    glm::vec3 low(0), high(0);
    for (const glm::vec3& p : mesh_.positions) {
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    return std::max(1e-30, double(glm::distance(low, high)));
  }

  // Cosine to the triangle's own normal; 1 for a triangle without area.
  double Uprightness(uint32_t triangle, const glm::dvec3& axis) const {
    const double length = glm::length(areas_[triangle]);
    return length > 0 ? glm::dot(areas_[triangle], axis) / length : 1;
  }

  // Spreads from the seed over free triangles that `accepts` takes, nearest first by steps.
  template <class Accepts>
  std::vector<uint32_t> Spread(uint32_t seed, const Accepts& accepts) const {
    std::vector<uint32_t> reached;
    std::unordered_set<uint32_t> tried{seed};
    if (accepts(seed)) reached.push_back(seed);
    for (size_t next = 0; next < reached.size(); ++next) {
      for (int k = 0; k < 3; ++k) {
        const uint32_t neighbor = neighbors_[reached[next]][k];
        if (chart_[neighbor] != kNone || !tried.insert(neighbor).second) continue;
        if (accepts(neighbor)) reached.push_back(neighbor);
      }
    }
    return reached;
  }

  // The area's mean normal around the seed, as far as normals agree with the mean so far.
  glm::dvec3 AxisAround(uint32_t seed) const {
    glm::dvec3 sum(0.0);
    glm::dvec3 first = smooth_[seed];
    // A triangle that stands across its surroundings starts with its own normal.
    if (Uprightness(seed, first) < kAgree) first = glm::normalize(areas_[seed]);
    Spread(seed, [&](uint32_t t) {
      const glm::dvec3 mean = sum == glm::dvec3(0.0) ? first : glm::normalize(sum);
      if (t != seed && glm::dot(smooth_[t], mean) < kAgree) return false;
      sum += t == seed ? first * std::max(1e-300, glm::length(areas_[t])) : areas_[t];
      return true;
    });
    const double length = glm::length(sum);
    const glm::dvec3 mean = length > 0 ? sum / length : first;
    return Uprightness(seed, mean) >= kStandsUp ? mean : first;
  }

  TextureChart Grow(uint32_t seed, uint32_t id) {
    TextureChart chart;
    const glm::dvec3 axis = glm::length(areas_[seed]) > 0 ? AxisAround(seed) : glm::dvec3(0, 0, 1);
    const glm::dvec3 across = std::abs(axis.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    chart.x = glm::normalize(glm::cross(across, axis));
    chart.y = glm::cross(axis, chart.x);
    PlaneTriangles plane(square_);
    chart.triangles = Spread(seed, [&](uint32_t t) {
      Corners corners;
      for (int k = 0; k < 3; ++k) {
        corners[size_t(k)] = chart.InPlane(mesh_.positions[mesh_.triangles[t][k]]);
      }
      const bool shows_nothing = glm::length(areas_[t]) == 0 || (t == seed && !(Area(corners) > 0));
      if (shows_nothing) return true;
      const bool fits = t == seed || glm::dot(smooth_[t], axis) >= kAgree;
      if (!fits || Uprightness(t, axis) < kStandsUp || !(Area(corners) > 0)) return t == seed;
      if (!plane.IsFree(corners)) return false;
      plane.Add(corners);
      return true;
    });
    for (const uint32_t t : chart.triangles) chart_[t] = id;
    return chart;
  }

  const TriangleMesh& mesh_;
  std::vector<glm::uvec3> neighbors_;
  std::vector<uint32_t> chart_;
  std::vector<glm::dvec3> areas_, smooth_;  // per triangle: normal times twice the area; unit
  double square_;
};

}  // namespace

std::vector<TextureChart> CutIntoCharts(const TriangleMesh& mesh) {
  return ChartCutter(mesh).Cut();
}

}  // namespace tetrec
