// Which level set of the density is the surface.
#pragma once

#include "field/radiance_field.h"
#include "geometry/bounds3.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>

namespace tetrec {

struct HalfTransmittanceLevel {
  double isovalue = 0;       // density there [1 / world unit]
  uint64_t rays = 0;         // cast
  uint64_t opaque_rays = 0;  // whose transmittance fell to one half inside the bounds
  uint64_t lost_rays = 0;    // whose march failed by rounding; they are left out
};

// The density at which a typical surface is met: the third quartile, over rays from the cameras to
// random points of `bounds`, of the density where transmittance has fallen to one half. (Not the
// median: in photo scenes up to half of these rays lose their light in the haze of places that no
// photo saw well.) An optimised wall
// is a soft ramp whose height depends on the scene's scale and on the tets' size, so no fixed
// density is right; half transmittance is where an eye would put the wall. Rays that are not
// stopped inside `bounds` do not count. Without cameras the rays come from a sphere around the
// bounds. Throws DataError where fewer than one ray in 100 is stopped, and where the mesh's
// boundary is not convex.
HalfTransmittanceLevel FindHalfTransmittanceLevel(const RadianceField& field, const Bounds3& bounds,
                                                  std::span<const glm::dvec3> cameras_in_world,
                                                  int rays, uint64_t seed);

}  // namespace tetrec
