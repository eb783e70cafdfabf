// Rigid transforms between frames. b_from_a transforms a point from frame a to frame b, so that
// frames meet in c_from_a = c_from_b * b_from_a.
#pragma once

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

namespace tetrec {

struct Rigid3 {
  glm::dmat3 rotation{1.0};  // orthonormal, det +1
  glm::dvec3 translation{0.0};

  glm::dvec3 operator*(const glm::dvec3& point) const { return rotation * point + translation; }
  Rigid3 operator*(const Rigid3& other) const {
    return {rotation * other.rotation, rotation * other.translation + translation};
  }
  Rigid3 Inverse() const {
    const glm::dmat3 inverse = glm::transpose(rotation);
    return {inverse, -(inverse * translation)};
  }
};

// A similarity: x_in_b = scale * rotation * x_in_a + translation.
struct Similarity3 {
  double scale = 1.0;
  glm::dmat3 rotation{1.0};
  glm::dvec3 translation{0.0};

  glm::dvec3 operator*(const glm::dvec3& point) const {
    return scale * (rotation * point) + translation;
  }
  Similarity3 operator*(const Similarity3& other) const {
    return {scale * other.scale, rotation * other.rotation,
            scale * (rotation * other.translation) + translation};
  }
  Similarity3 Inverse() const {
    const glm::dmat3 inverse = glm::transpose(rotation);
    return {1.0 / scale, inverse, -(inverse * translation) / scale};
  }
};

}  // namespace tetrec
