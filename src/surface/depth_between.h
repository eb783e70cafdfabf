// Depths between the pixels of a map.
#pragma once

#include "image/depth_map.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <optional>

namespace tetrec {

// Depths of neighbouring pixels that differ by more footprints belong to different surfaces.
inline constexpr double kJumpOfDepths_px = 8;

// Bilinear between the depths of four pixels (upper left, upper right, lower left, lower right), at
// `part` of the way to the right and down. Nothing if one has no depth, or if they differ by `jump`
// or more.
inline std::optional<double> DepthBetween(const std::array<double, 4>& depths,
                                          const glm::dvec2& part, double jump) {
  const auto [low, high] = std::minmax_element(depths.begin(), depths.end());
  if (*low == double(kNoDepth) || *high - *low >= jump) return std::nullopt;
  return glm::mix(glm::mix(depths[0], depths[1], part.x), glm::mix(depths[2], depths[3], part.x),
                  part.y);
}

}  // namespace tetrec
