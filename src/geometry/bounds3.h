// Axis-aligned boxes.
#pragma once

#include <glm/glm.hpp>

#include <algorithm>
#include <limits>
#include <span>

namespace tetrec {

struct Bounds3 {
  glm::dvec3 min{std::numeric_limits<double>::infinity()};
  glm::dvec3 max{-std::numeric_limits<double>::infinity()};

  bool IsEmpty() const { return min.x > max.x || min.y > max.y || min.z > max.z; }
  glm::dvec3 Center() const { return 0.5 * (min + max); }
  glm::dvec3 Size() const { return max - min; }
  double Diagonal() const { return glm::length(Size()); }
  void Add(const glm::dvec3& point) {
    min = glm::min(min, point);
    max = glm::max(max, point);
  }
  bool Contains(const glm::dvec3& p) const {
    return p.x >= min.x && p.y >= min.y && p.z >= min.z && p.x <= max.x && p.y <= max.y &&
           p.z <= max.z;
  }
  // Grown about its centre by a factor.
  Bounds3 Scaled(double factor) const {
    return {Center() - 0.5 * factor * Size(), Center() + 0.5 * factor * Size()};
  }
};

// The largest distance between neighbouring 32-bit floats in the box, as a share of its diagonal.
inline double StepOfFloats(const Bounds3& box) {
  const glm::dvec3 farthest = glm::max(glm::abs(box.min), glm::abs(box.max));
  const double largest = std::max({farthest.x, farthest.y, farthest.z});
  return largest * double(std::numeric_limits<float>::epsilon()) / box.Diagonal();
}
// What is far smaller than its distance from 0 loses its shape in floats.
inline constexpr double kLargestStepOfFloats = 1e-4;

inline Bounds3 BoundsOf(std::span<const glm::vec3> points) {
  Bounds3 bounds;
  for (const glm::vec3& point : points) bounds.Add(glm::dvec3(point));
  return bounds;
}

}  // namespace tetrec
