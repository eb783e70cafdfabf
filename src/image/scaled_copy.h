// Smaller and larger copies of one image.
#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>

namespace tetrec {

// True if an image of this size may be a copy of the original in another size: with the same aspect
// ratio, apart from sides that were rounded up or down.
inline bool IsScaledCopy(const glm::ivec2& copy, const glm::ivec2& original) {
  const double shape = double(original.y) / original.x;
  const bool both_sides_scaled =
      (copy.x < original.x && copy.y < original.y) || (copy.x > original.x && copy.y > original.y);
  return both_sides_scaled && std::abs(copy.y - shape * copy.x) <= std::max(1.0, shape);
}

}  // namespace tetrec
