// Cameras that look at a point.
#pragma once

#include "geometry/rigid3.h"

#include <cmath>

namespace tetrec {

// The rotation of a camera that looks along `forward` (unit length) with `up` upwards in its image.
// If the two are parallel its x is the world's x, or as near to it as `forward` allows.
inline glm::dmat3 CamFromWorldRotation(const glm::dvec3& forward, const glm::dvec3& up) {
  constexpr double kParallel = 1e-9;
  glm::dvec3 across = glm::cross(forward, up);
  if (!(glm::length(across) > kParallel)) {
    const glm::dvec3 x = std::abs(forward.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    across = x - glm::dot(x, forward) * forward;
  }
  const glm::dvec3 right = glm::normalize(across), down = glm::cross(forward, right);
  return glm::transpose(glm::dmat3(right, down, forward));
}

// A camera at `position` that looks at `target`.
inline Rigid3 CamLookingAt(const glm::dvec3& position, const glm::dvec3& target,
                           const glm::dvec3& up = glm::dvec3(0, 0, 1)) {
  const glm::dmat3 rotation = CamFromWorldRotation(glm::normalize(target - position), up);
  return {rotation, -(rotation * position)};
}

}  // namespace tetrec
