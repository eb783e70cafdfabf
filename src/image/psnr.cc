// Squared error and PSNR between a rendered image and the true one.
#include "image/psnr.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tetrec {
namespace {

int SquaredDifference(const uint8_t* a, const uint8_t* b) {
  int sum = 0;
  for (int c = 0; c < 3; ++c) sum += (a[c] - b[c]) * (a[c] - b[c]);
  return sum;
}

// Turns a sum of squared 8-bit differences over `pixels` pixels into a mean of fractions.
double AsMean(uint64_t sum, uint64_t pixels) {
  return double(sum) / (255.0 * 255.0 * 3.0 * double(pixels));
}

}  // namespace

void CheckSameSize(const Image& render, const Image& other, const char* other_is) {
  if (render.width <= 0 || render.height <= 0 || render.width != other.width ||
      render.height != other.height) {
    throw DataError(fmt::format("render is {}x{} px but its {} is {}x{} px; both must be equal",
                                render.width, render.height, other_is, other.width, other.height));
  }
}

double MeanSquaredError(const Image& render, const Image& truth) {
  CheckSameSize(render, truth, "ground truth");
  uint64_t sum = 0;
  for (int y = 0; y < render.height; ++y) {
    for (int x = 0; x < render.width; ++x) {
      sum += SquaredDifference(render.At(x, y), truth.At(x, y));
    }
  }
  return AsMean(sum, uint64_t(render.width) * render.height);
}

std::optional<double> MaskedMeanSquaredError(const Image& render, const Image& truth,
                                             const Image& mask) {
  CheckSameSize(render, truth, "ground truth");
  CheckSameSize(render, mask, "mask");
  uint64_t sum = 0, count = 0;
  for (int y = 0; y < render.height; ++y) {
    for (int x = 0; x < render.width; ++x) {
      if (mask.At(x, y)[0] < kSelectedByMask) continue;
      sum += SquaredDifference(render.At(x, y), truth.At(x, y));
      ++count;
    }
  }
  if (count == 0) return std::nullopt;
  return AsMean(sum, count);
}

double PsnrFromMse(double mse) {
  return mse > 0 ? -10 * std::log10(mse) : std::numeric_limits<double>::infinity();
}

double CappedPsnrFromMse(double mse) { return std::min(PsnrFromMse(mse), kPsnrCap_db); }

}  // namespace tetrec
