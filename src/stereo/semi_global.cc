// Semi-global matching on a cost volume.
#include "stereo/semi_global.h"

#include "core/error.h"
#include "core/wide_loops.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace tetrec {
namespace {

constexpr int16_t kFar = 16000;
constexpr int kBorder =
    8;  // entries before and behind a pixel's planes, so that d - 1 and d + 1 are

// The path costs of one row and direction, with borders of kFar.
class PathRow {
 public:
  PathRow(int width, int planes)
      : stride_(size_t(planes) + 2 * kBorder),
        costs_(stride_ * size_t(width), kFar),
        least_(size_t(width), 0) {}
  int16_t* At(int x) { return &costs_[stride_ * size_t(x) + kBorder]; }
  int16_t& Least(int x) { return least_[size_t(x)]; }

 private:
  size_t stride_;
  std::vector<int16_t> costs_;
  std::vector<int16_t> least_;  // the least cost of each pixel
};

// L(p, d) = C(p, d) + min(L(q, d), L(q, d +- 1) + P1, min L(q) + P2) - min L(q), q before p.
// Returns the least L(p).
TETREC_WIDE_LOOPS
int16_t Extend(const int16_t* __restrict before, int16_t least_before, int16_t small_step,
               int16_t jump, const uint8_t* __restrict cost, int planes, int16_t* __restrict path,
               int16_t* __restrict sum) {
  const int16_t limit = int16_t(least_before + jump);
  int16_t least = kFar;
  for (int d = 0; d < planes; ++d) {
    const int16_t stepped = int16_t(std::min<int16_t>(before[d - 1], before[d + 1]) + small_step);
    const int16_t best = std::min(std::min(before[d], stepped), limit);
    const int16_t value = int16_t(best - least_before + cost[d]);
    path[d] = value;
    sum[d] = int16_t(sum[d] + value);
    least = std::min(least, value);
  }
  return least;
}

// A path's first pixel has no pixel before it.
int16_t Begin(const uint8_t* cost, int planes, int16_t* __restrict path, int16_t* __restrict sum) {
  int16_t least = kFar;
  for (int d = 0; d < planes; ++d) {
    path[d] = cost[d];
    sum[d] = int16_t(sum[d] + cost[d]);
    least = std::min(least, path[d]);
  }
  return least;
}

class Aggregation {
 public:
  Aggregation(const CostVolume& volume, std::span<const float> grey,
              const SemiGlobalOptions& options)
      : volume_(volume), grey_(grey), options_(options), sums_(volume.costs.size(), 0) {}

  // From all pixels before in the order of `down`: rows from the top and pixels from the left, or
  // both from the other end. Called once each way, this covers eight directions.
  void Sweep(bool down) {
    const int step = down ? 1 : -1;
    // Beside the pixel before in the row, those of the row before: diagonal, straight, diagonal.
    std::vector<PathRow> before, now;
    for (int i = 0; i < 3; ++i) {
      before.emplace_back(volume_.width, volume_.planes);
      now.emplace_back(volume_.width, volume_.planes);
    }
    PathRow along(volume_.width, volume_.planes);
    for (int i = 0; i < volume_.height; ++i) {
      const int y = down ? i : volume_.height - 1 - i;
      for (int j = 0; j < volume_.width; ++j) {
        const int x = down ? j : volume_.width - 1 - j;
        Advance(along, along, x, y, -step, 0);
        for (int k = 0; k < 3; ++k) Advance(before[size_t(k)], now[size_t(k)], x, y, k - 1, -step);
      }
      std::swap(before, now);
    }
  }

  const int16_t* Sum(int x, int y) const { return &sums_[Offset(x, y)]; }

 private:
  size_t Pixel(int x, int y) const { return size_t(y) * size_t(volume_.width) + size_t(x); }
  size_t Offset(int x, int y) const { return Pixel(x, y) * size_t(volume_.planes); }

  void Advance(PathRow& from, PathRow& to, int x, int y, int dx, int dy) {
    const int bx = x + dx, by = y + dy;
    int16_t* sum = &sums_[Offset(x, y)];
    const uint8_t* cost = volume_.At(x, y);
    if (bx < 0 || by < 0 || bx >= volume_.width || by >= volume_.height) {
      to.Least(x) = Begin(cost, volume_.planes, to.At(x), sum);
      return;
    }
    const double difference = std::abs(double(grey_[Pixel(x, y)]) - double(grey_[Pixel(bx, by)]));
    const int jump =
        std::max(options_.small_step + 1, int(options_.jump / (1 + options_.edge * difference)));
    to.Least(x) = Extend(from.At(bx), from.Least(bx), int16_t(options_.small_step), int16_t(jump),
                         cost, volume_.planes, to.At(x), sum);
  }

  const CostVolume& volume_;
  std::span<const float> grey_;
  SemiGlobalOptions options_;
  std::vector<int16_t> sums_;
};

// The minimum of the parabola through three neighbouring values, the middle one the least.
float ParabolaOffset(int before, int least, int after) {
  const int curvature = before - 2 * least + after;
  return curvature > 0 ? 0.5f * float(before - after) / float(curvature) : 0.0f;
}

}  // namespace

PlaneChoice ChooseSmoothPlanes(const CostVolume& volume, std::span<const float> grey, int planes,
                               const SemiGlobalOptions& options) {
  TETREC_CHECK(planes >= 2 && planes <= volume.planes, "planes of a cost volume");
  Aggregation aggregation(volume, grey, options);
  aggregation.Sweep(true);
  aggregation.Sweep(false);
  PlaneChoice choice;
  const size_t pixels = size_t(volume.width) * size_t(volume.height);
  choice.plane.assign(pixels, -1);
  choice.cost.assign(pixels, kLargestCost);
  for (int y = 0; y < volume.height; ++y) {
    for (int x = 0; x < volume.width; ++x) {
      const int16_t* sum = aggregation.Sum(x, y);
      const int best = int(std::min_element(sum, sum + planes) - sum);
      if (best == 0 || best == planes - 1) continue;
      const size_t i = size_t(y) * size_t(volume.width) + size_t(x);
      choice.plane[i] = float(best) + ParabolaOffset(sum[best - 1], sum[best], sum[best + 1]);
      choice.cost[i] = volume.At(x, y)[best];
    }
  }
  return choice;
}

}  // namespace tetrec
