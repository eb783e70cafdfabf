// Rotation matrices from files: how far they are from a rotation, and the nearest one.
#pragma once

#include "geometry/rigid3.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>

namespace tetrec {

// Largest absolute entry of R^T R - I; infinite for a reflection or if an entry is not finite.
inline double DistanceFromRotation(const glm::dmat3& matrix) {
  const glm::dmat3 error = glm::transpose(matrix) * matrix - glm::dmat3(1.0);
  double largest = 0;
  for (int i = 0; i < 9; ++i) {
    const double entry = std::abs(error[i / 3][i % 3]);
    if (!std::isfinite(entry)) return INFINITY;
    largest = std::max(largest, entry);
  }
  return glm::determinant(matrix) > 0 ? largest : INFINITY;
}

// The rotation nearest to a matrix that is a rotation up to rounding: its polar factor, by Newton's
// iteration R <- (R + R^-T) / 2, which converges quadratically.
inline glm::dmat3 NearestRotation(glm::dmat3 matrix) {
  for (int i = 0; i < 8; ++i) {
    matrix = (matrix + glm::transpose(glm::inverse(matrix))) * 0.5;
  }
  return matrix;
}

// A camera's pose after its world was changed. Lengths in the camera's frame shrink with the world,
// which does not change the image.
inline Rigid3 CamFromWorld(const Rigid3& cam_from_input, const Similarity3& input_from_world) {
  return {cam_from_input.rotation * input_from_world.rotation,
          (cam_from_input * input_from_world.translation) / input_from_world.scale};
}

}  // namespace tetrec
