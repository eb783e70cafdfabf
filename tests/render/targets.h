// Training pictures for the renderers' tests.
#pragma once

#include "render/renderer.h"
#include "render/training_renderer.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace tetrec::test {

// Random pictures with premultiplied alpha. A corner of 4x5 pixels and some others are not judged.
inline std::vector<TargetImage> RandomTargets(size_t count, int width, int height) {
  std::mt19937 random(8);
  std::vector<TargetImage> targets(count, {width, height, {}});
  for (TargetImage& target : targets) {
    for (int i = 0; i < width * height; ++i) {
      const uint32_t alpha = uint32_t(random() % 256);
      uint32_t rgba = alpha << 24;
      for (int c = 0; c < 3; ++c) rgba |= uint32_t(random() % (alpha + 1)) << (8 * c);
      const bool in_corner = i % width < 4 && i / width < 5;
      target.rgba8.push_back(in_corner || random() % 16 == 0 ? kNotJudgedTarget : rgba);
    }
  }
  return targets;
}

// A rendered picture, rounded to 8 bits.
inline TargetImage TargetOf(const RenderedImage& image) {
  TargetImage target{image.width, image.height, {}};
  const auto byte = [](float value) {
    return uint32_t(std::lround(255.0f * std::clamp(value, 0.0f, 1.0f)));
  };
  for (size_t i = 0; i < image.color_srgb.size(); ++i) {
    const glm::vec3& c = image.color_srgb[i];
    target.rgba8.push_back(byte(c.r) | byte(c.g) << 8 | byte(c.b) << 16 |
                           byte(1.0f - image.transmittance[i]) << 24);
  }
  return target;
}

}  // namespace tetrec::test
