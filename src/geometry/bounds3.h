// Axis-aligned boxes.
#pragma once

#include <glm/glm.hpp>

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

inline Bounds3 BoundsOf(std::span<const glm::vec3> points) {
  Bounds3 bounds;
  for (const glm::vec3& point : points) bounds.Add(glm::dvec3(point));
  return bounds;
}

}  // namespace tetrec
