// Rays that pass through walls.
#pragma once

#include "geometry/bounds3.h"
#include "image/depth_map.h"
#include "surface/opacity_level.h"

#include <cstddef>

namespace tetrec {

struct PassingRays {
  size_t all = 0;      // that lose some of their light inside the bounds, and leave these unstopped
  size_t stopped = 0;  // of these, those that lose it at a wall

  PassingRays& operator+=(const PassingRays& other);
};

// Where photos show the same colour behind a wall as on it, optimisation lets light through, and a
// ray may leave the bounds of the surface before it has lost as much as the level asks for. If it
// loses more of its light within 5 % of its depth, from `first` to `second`, it is at a wall, and
// is stopped at `second`. Otherwise it may be in haze, so it is only known to be free up to
// `first`. `view` has the depths of the level; `first` and `second`, those of two lesser losses,
// are of the camera's size.
PassingRays MendPassingRays(const Bounds3& bounds_in_world, const DepthMap& first,
                            const DepthMap& second, SeenDepth& view);

}  // namespace tetrec
