// How close a rendered image is to the true one apart from exposure and white balance.
#include "eval/color_correction.h"

#include "image/psnr.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// The columns from `first` to before `last`.
Image CropColumns(const Image& image, int first, int last) {
  Image result{last - first, image.height, image.channels, {}};
  for (int y = 0; y < image.height; ++y) {
    const uint8_t* row = image.At(0, y);
    result.pixels.insert(result.pixels.end(), row + first * image.channels,
                         row + last * image.channels);
  }
  return result;
}

bool IsSelected(const Image* mask, int x, int y) {
  return !mask || mask->At(x, y)[0] >= kSelectedByMask;
}

std::optional<double> ErrorOf(const Image& render, const Image& truth, const Image* mask) {
  if (mask) return MaskedMeanSquaredError(render, truth, *mask);
  return MeanSquaredError(render, truth);
}

}  // namespace

ColorCorrection FitColors(const Image& render, const Image& truth, const Image* mask) {
  CheckSameSize(render, truth, "ground truth");
  if (mask) CheckSameSize(render, *mask, "mask");
  ColorCorrection correction;
  for (int c = 0; c < 3; ++c) {
    GainOffsetSums sums;
    for (int y = 0; y < render.height; ++y) {
      for (int x = 0; x < render.width; ++x) {
        if (!IsSelected(mask, x, y)) continue;
        sums.Add(render.At(x, y)[c] / 255.0, 1.0, truth.At(x, y)[c] / 255.0);
      }
    }
    if (sums.ww == 0) continue;
    correction[size_t(c)] =
        FitGainOffset(sums).value_or(GainOffset{1, (sums.yw - sums.xw) / sums.ww});
  }
  return correction;
}

Image WithColors(const Image& image, const ColorCorrection& correction) {
  Image result = image;
  for (size_t i = 0; i < result.pixels.size(); i += size_t(image.channels)) {
    for (size_t c = 0; c < 3; ++c) {
      const double value = correction[c].gain * image.pixels[i + c] + 255 * correction[c].offset;
      result.pixels[i + c] = uint8_t(std::lround(std::clamp(value, 0.0, 255.0)));
    }
  }
  return result;
}

std::optional<HalfScores> ScoreHalves(const Image& render, const Image& truth, const Image* mask) {
  CheckSameSize(render, truth, "ground truth");
  if (mask) CheckSameSize(render, *mask, "mask");
  const int middle = render.width / 2;
  if (middle == 0) return std::nullopt;
  const auto left = [&](const Image& image) { return CropColumns(image, 0, middle); };
  const auto right = [&](const Image& image) { return CropColumns(image, middle, image.width); };
  const Image left_mask = mask ? left(*mask) : Image{}, right_mask = mask ? right(*mask) : Image{};
  const Image *in_left = mask ? &left_mask : nullptr, *in_right = mask ? &right_mask : nullptr;
  if (!ErrorOf(left(render), left(truth), in_left)) return std::nullopt;
  const ColorCorrection correction = FitColors(left(render), left(truth), in_left);
  const Image judged = right(render), wanted = right(truth);
  const std::optional<double> raw = ErrorOf(judged, wanted, in_right);
  if (!raw) return std::nullopt;
  return HalfScores{*raw, ErrorOf(WithColors(judged, correction), wanted, in_right).value()};
}

}  // namespace tetrec
