// Charts are turned to fill their boxes, and the boxes are packed from the highest to the lowest.
#include "surface/texture_layout.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>

namespace tetrec {
namespace {

constexpr int kSmallestSize = 64;
constexpr double kFinerStep = 0.97;  // of the size of texels, while the best one is searched

// A chart turned in its plane so that its box is small.
struct FlatChart {
  std::vector<std::array<glm::dvec2, 3>> corners;  // per triangle of the chart, from 0 upwards
  glm::dvec2 extent{0.0};                          // [units of the mesh]
};

glm::dvec2 Turned(const glm::dvec2& p, double angle) {
  return {std::cos(angle) * p.x - std::sin(angle) * p.y,
          std::sin(angle) * p.x + std::cos(angle) * p.y};
}

struct Box {
  glm::dvec2 low{std::numeric_limits<double>::infinity()},
      high{-std::numeric_limits<double>::infinity()};

  void Add(const glm::dvec2& p) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  glm::dvec2 Extent() const { return high - low; }
};

FlatChart Flat(const TriangleMesh& mesh, const TextureChart& chart) {
  FlatChart flat;
  for (const uint32_t t : chart.triangles) {
    auto& corners = flat.corners.emplace_back();
    for (int k = 0; k < 3; ++k) {
      corners[size_t(k)] = chart.InPlane(mesh.positions[mesh.triangles[t][k]]);
    }
  }
  constexpr int kAngles = 12;  // of a quarter turn
  double best_area = std::numeric_limits<double>::infinity(), best_angle = 0;
  Box best;
  for (int i = 0; i < kAngles; ++i) {
    const double angle = 0.5 * std::numbers::pi * i / kAngles;
    Box box;
    for (const auto& corners : flat.corners) {
      for (const glm::dvec2& p : corners) box.Add(Turned(p, angle));
    }
    const double area = box.Extent().x * box.Extent().y;
    if (area < best_area) {
      best_area = area;
      best_angle = angle;
      best = box;
    }
  }
  for (auto& corners : flat.corners) {
    for (glm::dvec2& p : corners) p = Turned(p, best_angle) - best.low;
  }
  flat.extent = best.Extent();
  return flat;
}

// The upper outline of what has been packed, as steps from left to right.
class Skyline {
 public:
  explicit Skyline(int size) : size_(size), steps_{{0, 0, size}} {}

  // The lowest place for a box, and there the leftmost.
  std::optional<glm::ivec2> Put(const glm::ivec2& box) {
    std::optional<glm::ivec2> best;
    for (size_t s = 0; s < steps_.size(); ++s) {
      if (steps_[s].x + box.x > size_) break;
      int y = 0, covered = 0;
      for (size_t t = s; covered < box.x; ++t) {
        y = std::max(y, steps_[t].y);
        covered += steps_[t].width;
      }
      if (y + box.y <= size_ && (!best || y < best->y)) best = {steps_[s].x, y};
    }
    if (best) Raise(best->x, box.x, best->y + box.y);
    return best;
  }

 private:
  struct Step {
    int x, y, width;
  };

  void Raise(int x, int width, int y) {
    std::vector<Step> raised;
    for (const Step& step : steps_) {
      const int end = step.x + step.width;
      if (step.x < x) raised.push_back({step.x, step.y, std::min(end, x) - step.x});
      if (step.x <= x && x < end) raised.push_back({x, y, width});
      const int rest = std::max(step.x, x + width);
      if (rest < end) raised.push_back({rest, step.y, end - rest});
    }
    steps_.clear();
    for (const Step& step : raised) {
      if (!steps_.empty() && steps_.back().y == step.y) {
        steps_.back().width += step.width;
      } else {
        steps_.push_back(step);
      }
    }
  }

  int size_;
  std::vector<Step> steps_;
};

glm::ivec2 BoxOf(const FlatChart& chart, double texel_size) {
  // Checked before the conversion, which texels that are far too small would overflow.
  const glm::dvec2 texels = glm::min(glm::dvec2(1e8), glm::ceil(chart.extent / texel_size));
  return glm::ivec2(texels) + 2 * kTexturePadding;
}

// Where each chart's box begins; nothing if they do not fit.
std::optional<std::vector<glm::ivec2>> Pack(std::span<const FlatChart> charts, double texel_size,
                                            int size) {
  double area = 0;
  std::vector<glm::ivec2> boxes;
  for (const FlatChart& chart : charts) {
    boxes.push_back(BoxOf(chart, texel_size));
    area += double(boxes.back().x) * double(boxes.back().y);
  }
  if (area > double(size) * double(size)) return std::nullopt;
  std::vector<size_t> order(charts.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return boxes[a].y > boxes[b].y; });
  Skyline skyline(size);
  std::vector<glm::ivec2> places(charts.size());
  for (const size_t i : order) {
    const std::optional<glm::ivec2> place = skyline.Put(boxes[i]);
    if (!place) return std::nullopt;
    places[i] = *place;
  }
  return places;
}

struct Packing {
  double texel_size;
  std::vector<glm::ivec2> places;
};

// With the smallest texels that fit, starting from those with which the charts' boxes would fill
// the square without gaps and padding.
Packing PackFinest(std::span<const FlatChart> charts, int size) {
  double area = 0, longest = 0;
  for (const FlatChart& chart : charts) {
    area += chart.extent.x * chart.extent.y;
    longest = std::max({longest, chart.extent.x, chart.extent.y});
  }
  double texel_size = std::max({std::sqrt(area), longest, 1e-30}) / size;
  const double coarsest = 2 * std::max(longest, texel_size);
  for (; texel_size < coarsest; texel_size /= kFinerStep) {
    if (auto places = Pack(charts, texel_size, size)) return {texel_size, std::move(*places)};
  }
  throw UsageError(
      fmt::format("texture is {}; expected more texels for {} charts", size, charts.size()));
}

std::vector<FlatChart> FlatCharts(const TriangleMesh& mesh, std::span<const TextureChart> charts) {
  std::vector<FlatChart> flat;
  for (const TextureChart& chart : charts) flat.push_back(Flat(mesh, chart));
  return flat;
}

TextureLayout Placed(const TriangleMesh& mesh, std::span<const TextureChart> charts,
                     std::span<const FlatChart> flat, const Packing& packing, int size) {
  TextureLayout layout{size, packing.texel_size, {}};
  layout.corners.resize(mesh.triangles.size());
  for (size_t c = 0; c < charts.size(); ++c) {
    const glm::dvec2 begin = glm::dvec2(packing.places[c] + kTexturePadding);
    const double height = flat[c].extent.y;
    for (size_t i = 0; i < charts[c].triangles.size(); ++i) {
      auto& corners = layout.corners[charts[c].triangles[i]];
      for (size_t k = 0; k < 3; ++k) {
        const glm::dvec2 p = flat[c].corners[i][k];
        corners[k] = begin + glm::dvec2(p.x, height - p.y) / packing.texel_size;
      }
    }
  }
  return layout;
}

}  // namespace

TextureLayout LayOutTexture(const TriangleMesh& mesh, std::span<const TextureChart> charts,
                            double texel_size, int max_size) {
  const std::vector<FlatChart> flat = FlatCharts(mesh, charts);
  for (int size = std::min(kSmallestSize, max_size); size <= max_size; size *= 2) {
    if (size == max_size || Pack(flat, texel_size, size)) {
      return Placed(mesh, charts, flat, PackFinest(flat, size), size);
    }
  }
  throw BugError("sizes of textures are powers of two");
}

TextureLayout LayOutTextureOfSize(const TriangleMesh& mesh, std::span<const TextureChart> charts,
                                  int size) {
  const std::vector<FlatChart> flat = FlatCharts(mesh, charts);
  return Placed(mesh, charts, flat, PackFinest(flat, size), size);
}

std::vector<std::array<glm::vec2, 3>> CornerCoordinates(const TextureLayout& layout) {
  std::vector<std::array<glm::vec2, 3>> coordinates;
  for (const auto& corners : layout.corners) {
    auto& row = coordinates.emplace_back();
    for (size_t k = 0; k < 3; ++k) {
      row[k] = glm::vec2(corners[k].x / layout.size, 1 - corners[k].y / layout.size);
    }
  }
  return coordinates;
}

}  // namespace tetrec
