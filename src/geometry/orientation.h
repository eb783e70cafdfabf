// The side of a plane on which a point is, decided exactly.
#pragma once

#include <glm/glm.hpp>

namespace tetrec {

// Sign (-1, 0, 1) of det(b - a, c - a, d - a): 1 if a, b, c, d are positively oriented, 0 if and
// only if the four points are coplanar. Exact for all finite floats. Method: a filtered double
// evaluation, then Shewchuk's exact expansions (Adaptive Precision Floating-Point Arithmetic and
// Fast Robust Geometric Predicates, 1997).
int Orientation(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d);

}  // namespace tetrec
