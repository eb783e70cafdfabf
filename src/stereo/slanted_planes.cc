// Depths of a view on slanted planes, one for each pixel.
#include "stereo/slanted_planes.h"

#include "core/random.h"
#include "core/wide_loops.h"
#include "stereo/match_cost.h"
#include "stereo/view_projection.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {
namespace {

// Windows of every second pixel, up to kReach away. Arrays are padded to whole vectors with
// samples of weight 0.
constexpr int kReach = 4, kSamples = 32;
constexpr float kGreySpread = 0.1f, kReachSpread = 4.0f;  // of the weights: grey values, pixels
constexpr uint64_t kSeed = 1;
constexpr float kLeastGain = 1e-3f;  // in cost; for less, a pixel keeps its plane
constexpr double kSteepest = 8;      // tangent of the largest angle between plane and image

struct Window {
  std::array<float, kSamples> x{}, y{};  // from the middle [px]
  std::array<float, kSamples> weight{};  // sum: 1
  std::array<float, kSamples> grey{};    // less the weighted mean
  float inverse_deviation = 0;
};

// Inverse depth at a pixel [1 / world unit], and its change per pixel to the right and down.
struct Plane {
  float inverse_depth = 0;
  float right = 0, down = 0;
};

struct Source {
  const StereoView* view;
  glm::mat3 base;
  glm::vec3 shift;
};

Window WindowAround(const StereoView& view, int x0, int y0) {
  Window window;
  const int width = view.camera.width, height = view.camera.height;
  const float middle = view.grey[view.Index(x0, y0)];
  size_t i = 0;
  float weights = 0, mean = 0;
  for (int dy = -kReach; dy <= kReach; dy += 2) {
    for (int dx = -kReach; dx <= kReach; dx += 2) {
      const int x = x0 + dx, y = y0 + dy;
      if (x < 0 || y < 0 || x >= width || y >= height) continue;
      const float grey = view.grey[view.Index(x, y)];
      const float unlike = (grey - middle) / kGreySpread;
      const float far = float(dx * dx + dy * dy) / (kReachSpread * kReachSpread);
      window.x[i] = float(dx), window.y[i] = float(dy), window.grey[i] = grey;
      window.weight[i] = std::exp(-0.5f * (unlike * unlike + far));
      weights += window.weight[i];
      mean += window.weight[i] * grey;
      ++i;
    }
  }
  mean /= weights;
  float variance = 0;
  for (size_t k = 0; k < i; ++k) {
    window.weight[k] /= weights;
    window.grey[k] -= mean;
    variance += window.weight[k] * window.grey[k] * window.grey[k];
  }
  window.inverse_deviation = 1 / std::sqrt(variance + kNoiseVariance);
  return window;
}

// Where the samples of a window are in a neighbour: the first of the four pixels around, and the
// place between them.
struct Places {
  std::array<int, kSamples> at;
  std::array<float, kSamples> a, b;
};

TETREC_WIDE_LOOPS
void ProjectWindow(const float* __restrict start, const float* __restrict by_x,
                   const float* __restrict by_y, const float* __restrict x,
                   const float* __restrict y, int other_width, int other_height, int* __restrict at,
                   float* __restrict a, float* __restrict b) {
  const float right = float(other_width) - 0.501f, bottom = float(other_height) - 0.501f;
  for (int i = 0; i < kSamples; ++i) {
    const float q = start[2] + x[i] * by_x[2] + y[i] * by_y[2];
    const float scale = 1.0f / (q > 1e-6f ? q : 1e-6f);
    const float u = (start[0] + x[i] * by_x[0] + y[i] * by_y[0]) * scale;
    const float v = (start[1] + x[i] * by_x[1] + y[i] * by_y[1]) * scale;
    const float cu = std::min(std::max(u, 0.5f), right) - 0.5f;
    const float cv = std::min(std::max(v, 0.5f), bottom) - 0.5f;
    const int ix = int(cu), iy = int(cv);
    a[i] = cu - float(ix);
    b[i] = cv - float(iy);
    at[i] = iy * other_width + ix;
  }
}

// 1 - the weighted correlation with what one neighbour shows on the plane.
float CostIn(const Source& source, const Window& window, const Plane& plane,
             const glm::vec3& pixel) {
  const Camera& other = source.view->camera;
  const glm::vec3 start = source.base * pixel + plane.inverse_depth * source.shift;
  if (!(start.z > 1e-6f)) return kUnseen;
  const float u = start.x / start.z, v = start.y / start.z;
  if (!(u >= 0 && v >= 0 && u < float(other.width) && v < float(other.height))) return kUnseen;
  const PixelKind kind = source.view->kinds[source.view->Index(int(u), int(v))];
  if (kind != PixelKind::kSeen) return kind == PixelKind::kEmpty ? 1.0f : kUnseen;
  const glm::vec3 by_x = source.base[0] + plane.right * source.shift;
  const glm::vec3 by_y = source.base[1] + plane.down * source.shift;
  Places places;
  ProjectWindow(&start[0], &by_x[0], &by_y[0], window.x.data(), window.y.data(), other.width,
                other.height, places.at.data(), places.a.data(), places.b.data());
  float mean = 0, square = 0, product = 0;
  for (size_t i = 0; i < kSamples; ++i) {
    const float* p = source.view->grey.data() + places.at[i];
    const float* below = p + other.width;
    const float top = p[0] + places.a[i] * (p[1] - p[0]);
    const float low = below[0] + places.a[i] * (below[1] - below[0]);
    const float grey = top + places.b[i] * (low - top) - 0.5f;
    const float weighted = window.weight[i] * grey;
    mean += weighted;
    square += weighted * grey;
    product += weighted * window.grey[i];
  }
  const float variance = std::max(0.0f, square - mean * mean);
  const float r = product * window.inverse_deviation / std::sqrt(variance + kNoiseVariance);
  return std::min(1.0f, 1.0f - r);
}

class Fit {
 public:
  Fit(const StereoView& view, std::span<const StereoView* const> neighbors, const DepthRange& range)
      : view_(view),
        least_(float(1 / range.farthest)),
        largest_(float(1 / range.nearest)),
        random_(kSeed, view.view) {
    for (const StereoView* neighbor : neighbors) {
      const ViewProjection projection = ProjectionInto(view, *neighbor);
      sources_.push_back({neighbor, glm::mat3(projection.base), glm::vec3(projection.shift)});
    }
  }

  void Start(std::span<const float> inverse_depths) {
    const size_t pixels = view_.grey.size();
    planes_.resize(pixels);
    costs_.assign(pixels, kUnseen);
    windows_.resize(pixels);
    for (int y = 0; y < view_.camera.height; ++y) {
      for (int x = 0; x < view_.camera.width; ++x) {
        const size_t i = view_.Index(x, y);
        if (view_.kinds[i] != PixelKind::kSeen) continue;
        windows_[i] = WindowAround(view_, x, y);
        const float known = inverse_depths[i];
        planes_[i].inverse_depth =
            known > 0 ? known : least_ + float(random_.Uniform()) * (largest_ - least_);
        costs_[i] = CostOf(x, y, planes_[i]);
      }
    }
  }

  // In the order of a chessboard's colours, each pixel tries the planes of pixels around it, then
  // random changes of its own.
  void Round(double size) {
    for (const int color : {0, 1}) {
      for (int y = 0; y < view_.camera.height; ++y) {
        for (int x = (y + color) % 2; x < view_.camera.width; x += 2) {
          if (view_.kinds[view_.Index(x, y)] != PixelKind::kSeen) continue;
          TakeFromAround(x, y);
          Change(x, y, size);
        }
      }
    }
  }

  void Read(double max_cost, std::span<float> inverse_depths) const {
    for (size_t i = 0; i < planes_.size(); ++i) {
      inverse_depths[i] = double(costs_[i]) <= max_cost ? planes_[i].inverse_depth : 0.0f;
    }
  }

 private:
  float CostOf(int x, int y, const Plane& plane) const {
    const glm::vec3 pixel(float(x) + 0.5f, float(y) + 0.5f, 1.0f);
    const Window& window = windows_[view_.Index(x, y)];
    float best = kUnseen, second = kUnseen;
    for (const Source& source : sources_) {
      const float cost = CostIn(source, window, plane, pixel);
      second = std::min(second, std::max(best, cost));
      best = std::min(best, cost);
    }
    return CostOfNeighbors(best, second, sources_.size());
  }

  void Offer(int x, int y, const Plane& plane) {
    if (!(plane.inverse_depth >= least_ && plane.inverse_depth <= largest_)) return;
    const float steepest =
        float(kSteepest / std::min(view_.camera.fx, view_.camera.fy)) * plane.inverse_depth;
    if (std::abs(plane.right) > steepest || std::abs(plane.down) > steepest) return;
    const size_t i = view_.Index(x, y);
    const float cost = CostOf(x, y, plane);
    if (cost >= costs_[i] - kLeastGain) return;
    costs_[i] = cost;
    planes_[i] = plane;
  }

  void TakeFromAround(int x, int y) {
    static constexpr int kFrom[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1},
                                        {-5, 0}, {5, 0}, {0, -5}, {0, 5}};
    for (const auto& [dx, dy] : kFrom) {
      const int nx = x + dx, ny = y + dy;
      if (nx < 0 || ny < 0 || nx >= view_.camera.width || ny >= view_.camera.height) continue;
      const size_t from = view_.Index(nx, ny);
      if (!(costs_[from] < 1.0f)) continue;
      Plane plane = planes_[from];
      plane.inverse_depth -= float(dx) * plane.right + float(dy) * plane.down;
      Offer(x, y, plane);
    }
  }

  float Spread(double size) { return float(size * (2 * random_.Uniform() - 1)); }

  // Tries another depth and slope, then another depth alone, then another slope alone. `size` is 1
  // for changes of up to a tenth of the inverse depth and of up to 4 in the tangents.
  void Change(int x, int y, double size) {
    for (const int what : {3, 1, 2}) {
      Plane plane = planes_[view_.Index(x, y)];
      const float tangent = plane.inverse_depth / float(std::min(view_.camera.fx, view_.camera.fy));
      if ((what & 1) != 0) plane.inverse_depth += Spread(0.1 * size) * plane.inverse_depth;
      if ((what & 2) != 0) {
        plane.right += Spread(4 * size) * tangent;
        plane.down += Spread(4 * size) * tangent;
      }
      Offer(x, y, plane);
    }
  }

  const StereoView& view_;
  float least_, largest_;
  Random random_;
  std::vector<Source> sources_;
  std::vector<Window> windows_;
  std::vector<Plane> planes_;
  std::vector<float> costs_;
};

}  // namespace

void FitSlantedPlanes(const StereoView& view, std::span<const StereoView* const> neighbors,
                      const DepthRange& range, const SlantedOptions& options,
                      std::span<float> inverse_depths) {
  Fit fit(view, neighbors, range);
  fit.Start(inverse_depths);
  double size = 1;
  for (int round = 0; round < options.rounds; ++round, size *= 0.4) fit.Round(size);
  fit.Read(options.max_cost, inverse_depths);
}

}  // namespace tetrec
