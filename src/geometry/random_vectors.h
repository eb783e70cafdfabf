// Random points, directions and rotations.
#pragma once

#include "core/random.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <cmath>
#include <numbers>

namespace tetrec {

// Uniform in [0, 1)^3.
inline glm::dvec3 RandomInUnitCube(MersenneRandom& random) {
  const double x = random.Uniform(), y = random.Uniform(), z = random.Uniform();
  return {x, y, z};
}

// A unit vector, uniform over the sphere.
inline glm::dvec3 RandomDirection(MersenneRandom& random) {
  const double z = 2 * random.Uniform() - 1, angle = 2 * std::numbers::pi * random.Uniform();
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

// A unit quaternion, uniform over all rotations (Shoemake 1992, "Uniform random rotations").
inline glm::dquat RandomQuaternion(MersenneRandom& random) {
  const double u = random.Uniform(), a = 2 * std::numbers::pi * random.Uniform(),
               b = 2 * std::numbers::pi * random.Uniform();
  const double p = std::sqrt(1 - u), q = std::sqrt(u);
  return {p * std::sin(a), p * std::cos(a), q * std::sin(b), q * std::cos(b)};
}

}  // namespace tetrec
