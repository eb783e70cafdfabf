// On which side of a line a point of the plane lies.
#pragma once

#include <glm/glm.hpp>

namespace tetrec {

// Twice the signed area of the triangle (a, b, p): positive if p lies to the left of the way from a
// to b, and exactly 0 if p is a or b.
inline double SideOfLine(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
  const glm::dvec2 along = b - a, to = p - a;
  return along.x * to.y - along.y * to.x;
}

}  // namespace tetrec
