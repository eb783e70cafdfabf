// Depths of a view on slanted planes, one for each pixel.
//
// Windows of constant depth match badly where photos are far apart: from the next camera, a floor
// or a wall is squeezed. Here each pixel has a plane; planes that match well spread to the pixels
// around, and change at random (PatchMatch stereo, Bleyer et al. 2011, between several views
// as in Galliani et al. 2015). The pixels of a window count by their likeness to its middle.
#pragma once

#include "stereo/neighbors.h"
#include "stereo/stereo_view.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

struct SlantedOptions {
  int rounds = 4;         // in each, planes spread to other pixels and change
  double max_cost = 0.5;  // 1 - correlation of a depth that is kept
};

// Improves inverse depths (height x width [1 / world unit], 0: none) and drops those that match
// badly.
void FitSlantedPlanes(const StereoView& view, std::span<const StereoView* const> neighbors,
                      const DepthRange& range, const SlantedOptions& options,
                      std::span<float> inverse_depths);

}  // namespace tetrec
