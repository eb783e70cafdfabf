// D-SSIM of two images and its gradient, in double on the CPU.
#include "render/reference/dssim.h"

#include "core/error.h"
#include "shared/ssim.glsl.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

// Calls body(pixel, weight) for the pixels of the window around (x, y).
template <class Body>
void ForEachInWindow(int x, int y, int width, const Body& body) {
  for (int dy = -kSsimReach; dy <= kSsimReach; ++dy) {
    for (int dx = -kSsimReach; dx <= kSsimReach; ++dx) {
      body(size_t(y + dy) * size_t(width) + size_t(x + dx),
           SsimWindowWeight(double(dx)) * SsimWindowWeight(double(dy)));
    }
  }
}

}  // namespace

Dssim EvaluateDssim(std::span<const glm::dvec3> shown, std::span<const glm::dvec3> wanted,
                    int width, int height) {
  const size_t pixels = size_t(width) * size_t(height);
  const int columns = width - 2 * kSsimReach, rows = height - 2 * kSsimReach;
  TETREC_CHECK(columns > 0 && rows > 0 && shown.size() == pixels && wanted.size() == pixels,
               fmt::format("D-SSIM of {}x{} pixels", width, height));
  Dssim result{0, std::vector<glm::dvec3>(pixels, glm::dvec3(0.0))};
  const double share = 1.0 / (3.0 * columns * rows);
  for (int channel = 0; channel < 3; ++channel) {
    for (int y = kSsimReach; y < height - kSsimReach; ++y) {
      for (int x = kSsimReach; x < width - kSsimReach; ++x) {
        WindowMeans<double> mean{};
        ForEachInWindow(x, y, width, [&](size_t pixel, double weight) {
          const double a = shown[pixel][channel], b = wanted[pixel][channel];
          mean.x += weight * a;
          mean.y += weight * b;
          mean.xx += weight * a * a;
          mean.yy += weight * b * b;
          mean.xy += weight * a * b;
        });
        const SsimAdjoint<double> ssim = SsimWithDerivatives(mean);
        result.value += 0.5 * share * (1.0 - ssim.value);
        ForEachInWindow(x, y, width, [&](size_t pixel, double weight) {
          if (wanted[pixel][channel] < 0) return;
          result.gradient[pixel][channel] -= 0.5 * share * weight *
                                             (ssim.by_x + 2.0 * shown[pixel][channel] * ssim.by_xx +
                                              wanted[pixel][channel] * ssim.by_xy);
        });
      }
    }
  }
  return result;
}

}  // namespace tetrec
