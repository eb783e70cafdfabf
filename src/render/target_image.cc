// What a view should show, made from a stored image.
#include "render/target_image.h"

#include <algorithm>

namespace tetrec {
namespace {

TargetImage LeaveOutUnseen(const Image& image) {
  TargetImage target{image.width, image.height, {}};
  for (size_t i = 0; i < image.pixels.size(); i += 4) {
    const uint8_t* p = &image.pixels[i];
    const uint32_t seen = 255u << 24 | uint32_t(p[2]) << 16 | uint32_t(p[1]) << 8 | p[0];
    target.rgba8.push_back(p[3] >= kSeenAlpha ? seen : kNotJudgedTarget);
  }
  return target;
}

TargetImage Premultiply(const Image& image) {
  TargetImage target{image.width, image.height, {}};
  target.rgba8.resize(size_t(image.width) * image.height);
  for (size_t i = 0; i < target.rgba8.size(); ++i) {
    const uint8_t* p = &image.pixels[i * image.channels];
    const uint32_t alpha = image.channels == 4 ? p[3] : 255;
    uint32_t packed = alpha << 24;
    for (int c = 0; c < 3; ++c) packed |= (p[c] * alpha + 127) / 255 << (8 * c);
    target.rgba8[i] = packed;
  }
  return target;
}

Image OverBackground(const Image& image, Background background) {
  if (image.channels == 3) return image;
  const uint8_t level = background == Background::kWhite ? 255 : 0;
  return CompositeOver(image, level, level, level);
}

}  // namespace

TargetImage TargetOf(const Image& image, bool has_masks) {
  return has_masks && image.channels == 4 ? LeaveOutUnseen(image) : Premultiply(image);
}

Image TruthOf(const Image& image, bool has_masks, Background background) {
  Image truth = OverBackground(image, background);
  if (!has_masks || image.channels != 4) return truth;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const uint8_t* stored = image.At(x, y);
      if (stored[3] >= kSeenAlpha) std::copy_n(stored, 3, truth.At(x, y));
    }
  }
  return truth;
}

}  // namespace tetrec
