// Depths that photos confirm, in place of those at which a field's rays are stopped.
#pragma once

#include "geometry/camera.h"
#include "image/depth_map.h"
#include "run/stereo_depth.h"

#include <cstddef>

namespace tetrec {

// The stretch of each ray in which it loses its light. kNoDepth: it keeps more than that.
struct LossOfLight {
  DepthMap first, last;
};

// A ray may lose its light little by little, in haze or in a soft surface, so that the depth at
// which it is stopped depends on the level. Where the depth map of the view contains a depth in the
// stretch of the loss, or up to 1 % of the depth beside it, which enough other views confirm
// (kLeastAgreement), that depth replaces the one in `stopped`; depths of the map are linear between
// its pixels where these show one surface. `stopped` and `loss` are of the camera's size, the map
// may have another resolution. Returns the number of depths that were replaced.
size_t UseConfirmedDepths(const Camera& camera, const StereoDepth& map, const LossOfLight& loss,
                          DepthMap& stopped);

}  // namespace tetrec
