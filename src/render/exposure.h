// The exposure and white balance of training views, and the sums that they are fitted from.
#pragma once

#include "image/gain_offset.h"

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <span>

namespace tetrec {

// What a view shows of the field, by channel: shared/exposure.glsl.h.
struct ViewExposure {
  glm::dvec3 gain{1.0}, offset{0.0};  // [display sRGB]
  bool operator==(const ViewExposure&) const = default;
};

// Of one view, by channel: x the field's colour, w its opacity, y the colour wanted.
using ExposureSums = std::array<GainOffsetSums, 3>;

// Those of one block of rays.
struct BlockExposureSums {
  uint32_t view = 0;
  ExposureSums sums;
};

// Adds each block's sums to those of its view, in the order of the blocks.
inline void AddBlockSums(std::span<const BlockExposureSums> blocks, std::span<ExposureSums> views) {
  for (const BlockExposureSums& block : blocks) {
    for (size_t c = 0; c < 3; ++c) views[block.view][c] += block.sums[c];
  }
}

}  // namespace tetrec
