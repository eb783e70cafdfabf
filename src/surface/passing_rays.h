// Rays that pass through walls.
#pragma once

#include "geometry/bounds3.h"
#include "image/depth_map.h"
#include "surface/opacity_level.h"

#include <cstddef>

namespace tetrec {

// Where the rays of a view have lost more and more of their light, each of the camera's size.
struct DepthsOfLoss {
  DepthMap first, second, level;  // the last is what the surface is made of
};

struct PassingRays {
  size_t stopped = 0;  // at a wall, before their depth at the level
  size_t open = 0;     // known only up to where they have lost some of their light

  PassingRays& operator+=(const PassingRays& other);
};

// Where photos show the same colour behind a wall as on it, optimisation lets light through: rays
// pass through it before they have lost as much as the level asks for. A ray is at a wall if it
// loses more of its light, from `first` to `second`, within 5 % of its depth; if its depth at the
// level is farther behind than that, or outside of the bounds of the surface, it is stopped at
// `second`. Other rays that leave the bounds after some loss may have met haze, and are only known
// to be free up to `first`. Rays whose depth in `view` is not that of the level are known better,
// and stay.
PassingRays MendPassingRays(const Bounds3& bounds_in_world, const DepthsOfLoss& loss,
                            SeenDepth& view);

}  // namespace tetrec
