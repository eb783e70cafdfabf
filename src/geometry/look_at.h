// Cameras that look at a point.
#pragma once

#include "geometry/rigid3.h"

#include <cmath>

namespace tetrec {

// A camera at `position` that looks at `target`, the world's z up; along z itself its x is the
// world's.
inline Rigid3 CamLookingAt(const glm::dvec3& position, const glm::dvec3& target) {
  const glm::dvec3 forward = glm::normalize(target - position);
  const glm::dvec3 across = glm::cross(forward, glm::dvec3(0, 0, 1));
  constexpr double kParallel = 1e-9;
  const glm::dvec3 right =
      glm::length(across) > kParallel ? glm::normalize(across) : glm::dvec3(1, 0, 0);
  const glm::dvec3 down = glm::cross(forward, right);
  const glm::dmat3 rotation = glm::transpose(glm::dmat3(right, down, forward));
  return {rotation, -(rotation * position)};
}

}  // namespace tetrec
