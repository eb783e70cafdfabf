// How well each pixel of a view fits its neighbours, for planes of constant depth.
//
// Plane sweep (Collins 1996) in inverse depth with zero-mean normalised cross-correlation, which no
// gain or offset between photos changes.
#pragma once

#include "stereo/neighbors.h"
#include "stereo/stereo_view.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Planes at equal steps of inverse depth, the farthest first.
struct SweepPlanes {
  double first = 0, step = 0;  // inverse depth [1 / world unit]
  int count = 0;

  double InverseDepth(double plane) const { return first + step * plane; }
};

// So many planes that from one to the next no pixel moves by more than `step_px` in a neighbour,
// at most `max_planes`.
SweepPlanes ChoosePlanes(const StereoView& view, std::span<const StereoView* const> neighbors,
                         const DepthRange& range, double step_px, int max_planes);

// Costs of a view's pixels and planes.
struct CostVolume {
  int width = 0, height = 0;
  int planes = 0;              // a multiple of 16; those that fill up have the largest cost
  std::vector<uint8_t> costs;  // height x width x planes

  const uint8_t* At(int x, int y) const {
    return &costs[(size_t(y) * size_t(width) + size_t(x)) * size_t(planes)];
  }
};

// A cost is 255 (1 - r), r the correlation of the windows of (2 radius + 1)^2 pixels, 0 where it is
// negative, of several neighbours as in CostOfNeighbors. kUnknownCost where no neighbour sees it.
// Where a neighbour shows the empty background nothing can be, so its cost is the largest.
CostVolume SweepPlanesOf(const StereoView& view, std::span<const StereoView* const> neighbors,
                         const SweepPlanes& planes, int radius);

inline constexpr uint8_t kLargestCost = 255, kUnknownCost = 160;

}  // namespace tetrec
