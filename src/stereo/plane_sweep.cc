// Plane sweep with zero-mean normalised cross-correlation.
#include "stereo/plane_sweep.h"

#include "core/error.h"
#include "core/wide_loops.h"
#include "stereo/match_cost.h"
#include "stereo/view_projection.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// Sums over the windows of one row, from sums over their columns.
struct RowSums {
  std::vector<float> sum, square, product;  // columns, `radius` wider on both sides
};

// A view's window statistics, the same for all planes.
struct WindowStats {
  std::vector<float> mean, inverse_deviation;  // height x width
};

int Clamped(int i, int size) { return std::clamp(i, 0, size - 1); }

// Adds `sign` times a row to the columns' sums.
TETREC_WIDE_LOOPS
void AddRow(const float* __restrict warped, const float* __restrict grey, int width, float sign,
            float* __restrict sum, float* __restrict square, float* __restrict product) {
  for (int x = 0; x < width; ++x) {
    const float w = warped[x];
    const float signed_w = sign * w;
    sum[x] += signed_w;
    square[x] += signed_w * w;
    product[x] += signed_w * grey[x];
  }
}

void ExtendBorders(std::vector<float>& columns, int width, int radius) {
  for (int i = 0; i < radius; ++i) {
    columns[size_t(i)] = columns[size_t(radius)];
    columns[size_t(radius + width + i)] = columns[size_t(radius + width - 1)];
  }
}

// out[x] = sum of columns[x .. x + 2 radius].
TETREC_WIDE_LOOPS
void AddColumns(const float* __restrict columns, int width, int radius, float* __restrict out) {
  for (int x = 0; x < width; ++x) out[x] = columns[x];
  for (int i = 1; i <= 2 * radius; ++i) {
    for (int x = 0; x < width; ++x) out[x] += columns[x + i];
  }
}

// Calls visit(y, sum, square, product) with the windows' sums of each row; images continue beyond
// their borders as at them.
template <class Visit>
void ForEachWindowRow(const float* warped, const float* grey, int width, int height, int radius,
                      Visit&& visit) {
  const size_t padded = size_t(width + 2 * radius);
  RowSums columns{std::vector<float>(padded), std::vector<float>(padded),
                  std::vector<float>(padded)};
  std::vector<float> sum(size_t(width), 0.0f), square = sum, product = sum;
  const auto add = [&](int y, float sign) {
    const size_t row = size_t(Clamped(y, height)) * size_t(width);
    AddRow(warped + row, grey + row, width, sign, columns.sum.data() + radius,
           columns.square.data() + radius, columns.product.data() + radius);
  };
  for (int y = -radius; y < radius; ++y) add(y, 1);
  for (int y = 0; y < height; ++y) {
    add(y + radius, 1);
    for (std::vector<float>* c : {&columns.sum, &columns.square, &columns.product}) {
      ExtendBorders(*c, width, radius);
    }
    AddColumns(columns.sum.data(), width, radius, sum.data());
    AddColumns(columns.square.data(), width, radius, square.data());
    AddColumns(columns.product.data(), width, radius, product.data());
    visit(y, sum.data(), square.data(), product.data());
    add(y - radius, -1);
  }
}

// Grey values less a half, so that sums of squares lose fewer digits.
std::vector<float> Centered(const std::vector<float>& grey) {
  std::vector<float> centered(grey);
  for (float& g : centered) g -= 0.5f;
  return centered;
}

WindowStats MeasureWindows(const std::vector<float>& grey, int width, int height, int radius) {
  WindowStats stats;
  stats.mean.resize(grey.size());
  stats.inverse_deviation.resize(grey.size());
  const float share = 1.0f / float((2 * radius + 1) * (2 * radius + 1));
  ForEachWindowRow(grey.data(), grey.data(), width, height, radius,
                   [&](int y, const float* sum, const float* square, const float*) {
                     for (int x = 0; x < width; ++x) {
                       const size_t i = size_t(y) * size_t(width) + size_t(x);
                       const float mean = sum[x] * share;
                       const float variance = std::max(0.0f, square[x] * share - mean * mean);
                       stats.mean[i] = mean;
                       stats.inverse_deviation[i] = 1.0f / std::sqrt(variance + kNoiseVariance);
                     }
                   });
  return stats;
}

// A neighbour's image as a view would show it if everything were on one plane.
struct Warped {
  std::vector<float> grey;        // height x width, less a half
  std::vector<float> least_cost;  // height x width: 0, or 1 on empty background, or kUnseen
};

// A view's neighbour, prepared for warping.
struct Source {
  const StereoView* view;
  ViewProjection projection;
  std::vector<float> grey;        // less a half
  std::vector<float> least_cost;  // by pixel
};

float LeastCost(PixelKind kind) {
  return kind == PixelKind::kSeen ? 0.0f : kind == PixelKind::kEmpty ? 1.0f : kUnseen;
}

// Where the pixels of a row are in a neighbour.
struct RowTargets {
  std::vector<int> at, nearest;  // first of the four pixels around; the pixel that contains it
  std::vector<float> a, b;       // the place between the four, right and down, 0 to 1
  std::vector<float> unseen;     // kUnseen outside of the image, otherwise 0
};

// Projects start + x step (homogeneous) for each pixel of a row. Separate from the look-up, which
// the compiler does not vectorise.
TETREC_WIDE_LOOPS
void ProjectRow(const float* __restrict start, const float* __restrict step, int other_width,
                int other_height, int width, int* __restrict at, int* __restrict nearest,
                float* __restrict a, float* __restrict b, float* __restrict unseen) {
  const float right = float(other_width), bottom = float(other_height);
  const float x0 = start[0], y0 = start[1], z0 = start[2];
  const float dx = step[0], dy = step[1], dz = step[2];
  for (int x = 0; x < width; ++x) {
    const float fx = float(x);
    const float qz = z0 + fx * dz;
    const float scale = 1.0f / (qz > 1e-6f ? qz : 1e-6f);
    const float u = (x0 + fx * dx) * scale, v = (y0 + fx * dy) * scale;
    const float cu = std::min(std::max(u, 0.5f), right - 0.501f);
    const float cv = std::min(std::max(v, 0.5f), bottom - 0.501f);
    const float outside = std::max(std::max(-u, u - right), std::max(-v, v - bottom));
    unseen[x] = qz > 1e-6f ? (outside < 0.0f ? 0.0f : kUnseen) : kUnseen;
    const int ix = int(cu - 0.5f), iy = int(cv - 0.5f);
    a[x] = cu - 0.5f - float(ix);
    b[x] = cv - 0.5f - float(iy);
    at[x] = iy * other_width + ix;
    nearest[x] = int(cv) * other_width + int(cu);
  }
}

// Bilinear grey values, and the least cost of the nearest pixel.
void LookUpRow(const Source& source, const RowTargets& targets, int width,
               float* __restrict out_grey, float* __restrict out_least) {
  const int below = source.view->camera.width;
  for (int x = 0; x < width; ++x) {
    const size_t i = size_t(x);
    const float* p = source.grey.data() + targets.at[i];
    const float top = p[0] + targets.a[i] * (p[1] - p[0]);
    const float low = p[below] + targets.a[i] * (p[below + 1] - p[below]);
    out_grey[x] = top + targets.b[i] * (low - top);
    out_least[x] = std::max(targets.unseen[i], source.least_cost[size_t(targets.nearest[i])]);
  }
}

void Warp(const Camera& camera, const Source& source, double inverse_depth, RowTargets& targets,
          Warped& warped) {
  const glm::vec3 step(source.projection.base[0]);
  const Camera& other = source.view->camera;
  for (int y = 0; y < camera.height; ++y) {
    const glm::vec3 start(source.projection.base * glm::dvec3(0.5, y + 0.5, 1) +
                          inverse_depth * source.projection.shift);
    const size_t row = size_t(y) * size_t(camera.width);
    ProjectRow(&start[0], &step[0], other.width, other.height, camera.width, targets.at.data(),
               targets.nearest.data(), targets.a.data(), targets.b.data(), targets.unseen.data());
    LookUpRow(source, targets, camera.width, &warped.grey[row], &warped.least_cost[row]);
  }
}

// The costs of one plane: the best two of the neighbours.
struct PlaneCosts {
  std::vector<float> best, second;  // height x width; kUnseen: none
};

// One row of one neighbour: 1 - r, offered to the best two.
TETREC_WIDE_LOOPS
void OfferCosts(const float* __restrict sum, const float* __restrict square,
                const float* __restrict product, const float* __restrict mean,
                const float* __restrict inverse_deviation, const float* __restrict least_cost,
                float share, int width, float* __restrict best, float* __restrict second) {
  for (int x = 0; x < width; ++x) {
    const float warped_mean = sum[x] * share;
    const float variance = std::max(0.0f, square[x] * share - warped_mean * warped_mean);
    const float covariance = product[x] * share - warped_mean * mean[x];
    const float r = covariance * inverse_deviation[x] / std::sqrt(variance + kNoiseVariance);
    const float cost = std::max(std::min(1.0f, 1.0f - r), least_cost[x]);
    second[x] = std::min(second[x], std::max(best[x], cost));
    best[x] = std::min(best[x], cost);
  }
}

// Turns the best two costs of each pixel into bytes.
TETREC_WIDE_LOOPS
void MixCosts(const float* __restrict best, const float* __restrict second, size_t neighbors,
              size_t pixels, uint8_t* __restrict costs) {
  for (size_t i = 0; i < pixels; ++i) {
    const float mixed = CostOfNeighbors(best[i], second[i], neighbors);
    const float cost = std::max(0.0f, mixed) * float(kLargestCost) + 0.5f;
    costs[i] = best[i] < kUnseen ? uint8_t(int(cost)) : kUnknownCost;
  }
}

void Store(const std::vector<uint8_t>& costs, int plane, CostVolume& volume) {
  uint8_t* out = volume.costs.data() + plane;
  for (size_t i = 0; i < costs.size(); ++i) out[i * size_t(volume.planes)] = costs[i];
}

std::vector<Source> MakeSources(const StereoView& view,
                                std::span<const StereoView* const> neighbors) {
  std::vector<Source> sources;
  for (const StereoView* neighbor : neighbors) {
    Source source{neighbor, ProjectionInto(view, *neighbor), Centered(neighbor->grey), {}};
    for (const PixelKind kind : neighbor->kinds) source.least_cost.push_back(LeastCost(kind));
    sources.push_back(std::move(source));
  }
  return sources;
}

}  // namespace

SweepPlanes ChoosePlanes(const StereoView& view, std::span<const StereoView* const> neighbors,
                         const DepthRange& range, double step_px, int max_planes) {
  TETREC_CHECK(!range.IsEmpty() && max_planes >= 2, "planes of a sweep");
  SweepPlanes planes;
  planes.first = 1 / range.farthest;
  const double span = 1 / range.nearest - planes.first;
  // Pixels move along their epipolar lines nearly in proportion to inverse depth; the corners and
  // the middle tell how fast.
  double longest = 1;
  for (const StereoView* neighbor : neighbors) {
    const ViewProjection projection = ProjectionInto(view, *neighbor);
    for (const double x : {0.1, 0.5, 0.9}) {
      for (const double y : {0.1, 0.5, 0.9}) {
        const glm::dvec3 ray =
            projection.base * glm::dvec3(x * view.camera.width, y * view.camera.height, 1);
        const glm::dvec3 a = ray + planes.first * projection.shift;
        const glm::dvec3 b = ray + (planes.first + span) * projection.shift;
        if (!(a.z > 0 && b.z > 0)) continue;
        longest = std::max(longest, glm::distance(glm::dvec2(a) / a.z, glm::dvec2(b) / b.z));
      }
    }
  }
  planes.count = std::clamp(int(std::ceil(longest / step_px)) + 1, 2, max_planes);
  planes.step = span / (planes.count - 1);
  return planes;
}

CostVolume SweepPlanesOf(const StereoView& view, std::span<const StereoView* const> neighbors,
                         const SweepPlanes& planes, int radius) {
  const int width = view.camera.width, height = view.camera.height;
  const size_t pixels = size_t(width) * size_t(height);
  CostVolume volume{width, height, (planes.count + 15) / 16 * 16, {}};
  volume.costs.assign(pixels * size_t(volume.planes), kLargestCost);

  const std::vector<float> grey = Centered(view.grey);
  const WindowStats stats = MeasureWindows(grey, width, height, radius);
  const float share = 1.0f / float((2 * radius + 1) * (2 * radius + 1));
  const std::vector<Source> sources = MakeSources(view, neighbors);
  Warped warped{std::vector<float>(pixels), std::vector<float>(pixels)};
  const std::vector<float> row_floats(size_t(width), 0.0f);
  const std::vector<int> row_ints(size_t(width), 0);
  RowTargets targets{row_ints, row_ints, row_floats, row_floats, row_floats};
  PlaneCosts plane;
  std::vector<uint8_t> costs(pixels);
  for (int d = 0; d < planes.count; ++d) {
    plane.best.assign(pixels, kUnseen);
    plane.second.assign(pixels, kUnseen);
    for (const Source& source : sources) {
      Warp(view.camera, source, planes.InverseDepth(d), targets, warped);
      ForEachWindowRow(warped.grey.data(), grey.data(), width, height, radius,
                       [&](int y, const float* sum, const float* square, const float* product) {
                         const size_t row = size_t(y) * size_t(width);
                         OfferCosts(sum, square, product, &stats.mean[row],
                                    &stats.inverse_deviation[row], &warped.least_cost[row], share,
                                    width, &plane.best[row], &plane.second[row]);
                       });
    }
    MixCosts(plane.best.data(), plane.second.data(), neighbors.size(), pixels, costs.data());
    Store(costs, d, volume);
  }
  return volume;
}

}  // namespace tetrec
