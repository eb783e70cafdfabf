// The choice of the density level that is the surface.
#pragma once

#include "field/radiance_field.h"
#include "geometry/bounds3.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>

namespace tetrec {

struct HalfTransmittanceLevel {
  double isovalue = 0;       // [1 / world unit]
  uint64_t rays = 0;         // cast
  uint64_t opaque_rays = 0;  // rays whose transmittance fell to one half inside the bounds
  uint64_t lost_rays = 0;    // rays whose march failed because of rounding; they are ignored
};

// The density at a typical surface: rays run from the cameras to random points of `bounds`, and the
// result is the third quartile of the densities where their transmittance has fallen to one half.
// (Not the median, because in photo scenes up to half of the rays lose their light in haze that no
// photo saw well.) An optimised wall is a soft ramp whose height depends on the scene's scale and
// on the size of the tets, so no fixed density is right; half transmittance is where an eye would
// put the wall. Rays that are not stopped inside `bounds` do not count. Without cameras the rays
// come from a sphere around the bounds. Throws DataError if fewer than one ray in 100 is stopped or
// the boundary of the mesh is not convex.
HalfTransmittanceLevel FindHalfTransmittanceLevel(const RadianceField& field, const Bounds3& bounds,
                                                  std::span<const glm::dvec3> cameras_in_world,
                                                  int rays, uint64_t seed);

}  // namespace tetrec
