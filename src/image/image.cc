// Images in memory: other sizes, compositing and masks.
#include "image/image.h"

#include "core/error.h"
#include "image/resize.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

// The source pixels under one target pixel along one axis; weights sum to 1.
struct Coverage {
  int first = 0;
  std::vector<double> weights;
};

std::vector<Coverage> CoverAxis(int source_size, int target_size) {
  std::vector<Coverage> axis(size_t(target_size), Coverage{});
  for (int64_t i = 0; i < target_size; ++i) {
    // In units of 1 / target_size of a source pixel everything is an integer: no rounding.
    const int64_t begin = i * source_size, end = begin + source_size;
    Coverage& coverage = axis[size_t(i)];
    coverage.first = int(begin / target_size);
    for (int64_t s = coverage.first; s * target_size < end; ++s) {
      const int64_t covered =
          std::min(end, (s + 1) * target_size) - std::max(begin, s * target_size);
      coverage.weights.push_back(double(covered) / source_size);
    }
  }
  return axis;
}

// The two source pixels around each target pixel's centre.
std::vector<Coverage> InterpolateAxis(int source_size, int target_size) {
  std::vector<Coverage> axis(size_t(target_size), Coverage{});
  for (int i = 0; i < target_size; ++i) {
    const double at =
        std::clamp((i + 0.5) * source_size / target_size - 0.5, 0.0, source_size - 1.0);
    Coverage& coverage = axis[size_t(i)];
    coverage.first = std::min(int(at), std::max(source_size - 2, 0));
    const double share = at - coverage.first;
    coverage.weights = {1 - share};
    if (source_size > 1) coverage.weights.push_back(share);
  }
  return axis;
}

uint8_t ToByte(double value) { return uint8_t(std::clamp(value + 0.5, 0.0, 255.0)); }

Image Filtered(const Image& image, const std::vector<Coverage>& columns,
               const std::vector<Coverage>& rows) {
  Image target = MakeImage(int(columns.size()), int(rows.size()), image.channels);
  const bool has_alpha = image.channels == 4;
  for (int y = 0; y < target.height; ++y) {
    for (int x = 0; x < target.width; ++x) {
      const Coverage &column = columns[size_t(x)], &row = rows[size_t(y)];
      double sum[3] = {0, 0, 0}, sum_alpha = 0;
      for (size_t j = 0; j < row.weights.size(); ++j) {
        const uint8_t* source = image.At(column.first, row.first + int(j));
        for (size_t i = 0; i < column.weights.size(); ++i, source += image.channels) {
          const double weight = row.weights[j] * column.weights[i] * (has_alpha ? source[3] : 1.0);
          for (int c = 0; c < 3; ++c) sum[c] += weight * source[c];
          sum_alpha += weight;
        }
      }
      uint8_t* pixel = target.At(x, y);
      if (has_alpha) pixel[3] = ToByte(sum_alpha);
      if (has_alpha && pixel[3] == 0) continue;
      for (int c = 0; c < 3; ++c) pixel[c] = ToByte(sum[c] / sum_alpha);
    }
  }
  return target;
}

}  // namespace

Image MakeImage(int width, int height, int channels) {
  TETREC_CHECK(width > 0 && height > 0 && (channels == 3 || channels == 4),
               fmt::format("{} x {} x {}", width, height, channels));
  Image image{width, height, channels, {}};
  image.pixels.resize(size_t(width) * size_t(height) * size_t(channels));
  return image;
}

Image ResizeByArea(const Image& image, int width, int height) {
  return Filtered(image, CoverAxis(image.width, width), CoverAxis(image.height, height));
}

Image ResizeSmoothly(const Image& image, int width, int height) {
  const auto axis = [](int from, int to) {
    return to > from ? InterpolateAxis(from, to) : CoverAxis(from, to);
  };
  return Filtered(image, axis(image.width, width), axis(image.height, height));
}

Image TurnedClockwise(const Image& image, int quarters) {
  if (quarters % 4 == 0) return image;
  const int right = image.width - 1, bottom = image.height - 1;
  const bool swaps_sides = quarters % 2 == 1;
  Image turned = swaps_sides ? MakeImage(image.height, image.width, image.channels)
                             : MakeImage(image.width, image.height, image.channels);
  for (int y = 0; y < turned.height; ++y) {
    for (int x = 0; x < turned.width; ++x) {
      const uint8_t* source = quarters % 4 == 1   ? image.At(y, bottom - x)
                              : quarters % 4 == 2 ? image.At(right - x, bottom - y)
                                                  : image.At(right - y, x);
      std::copy_n(source, image.channels, turned.At(x, y));
    }
  }
  return turned;
}

Image CompositeOver(const Image& rgba, uint8_t r, uint8_t g, uint8_t b) {
  TETREC_CHECK(rgba.channels == 4, "compositing needs alpha");
  Image rgb = MakeImage(rgba.width, rgba.height, 3);
  const int background[3] = {r, g, b};
  const size_t count = size_t(rgba.width) * size_t(rgba.height);
  for (size_t i = 0; i < count; ++i) {
    const int alpha = rgba.pixels[4 * i + 3];
    for (size_t c = 0; c < 3; ++c) {
      const int mixed = rgba.pixels[4 * i + c] * alpha + background[c] * (255 - alpha);
      rgb.pixels[3 * i + c] = uint8_t((mixed + 127) / 255);
    }
  }
  return rgb;
}

Image MaskedBy(const Image& image, const Image& mask) {
  Image grey = MakeImage(mask.width, mask.height, 3);
  const size_t mask_pixels = size_t(mask.width) * size_t(mask.height);
  int brightest = 0;
  for (size_t i = 0; i < mask_pixels; ++i) {
    const uint8_t* source = &mask.pixels[i * size_t(mask.channels)];
    const int alpha = mask.channels == 4 ? source[3] : 255;
    const int level = (std::max({source[0], source[1], source[2]}) * alpha + 127) / 255;
    brightest = std::max(brightest, level);
    std::fill_n(&grey.pixels[3 * i], 3, uint8_t(level));
  }
  if (brightest == 1) {
    for (uint8_t& level : grey.pixels) level = uint8_t(255 * level);
  }
  if (grey.width != image.width || grey.height != image.height) {
    grey = ResizeByArea(grey, image.width, image.height);
  }
  Image masked = MakeImage(image.width, image.height, 4);
  const size_t count = size_t(image.width) * size_t(image.height);
  for (size_t i = 0; i < count; ++i) {
    const uint8_t* source = &image.pixels[i * size_t(image.channels)];
    const int alpha = image.channels == 4 ? source[3] : 255;
    std::copy_n(source, 3, &masked.pixels[4 * i]);
    masked.pixels[4 * i + 3] = uint8_t((alpha * grey.pixels[3 * i] + 127) / 255);
  }
  return masked;
}

std::vector<uint8_t> AlphaOf(const Image& rgba) {
  TETREC_CHECK(rgba.channels == 4, "an image without alpha");
  std::vector<uint8_t> alpha(size_t(rgba.width) * size_t(rgba.height));
  for (size_t i = 0; i < alpha.size(); ++i) alpha[i] = rgba.pixels[4 * i + 3];
  return alpha;
}

}  // namespace tetrec
