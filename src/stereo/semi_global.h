// Smooth depth from matching costs.
//
// Semi-global matching (Hirschmueller 2008): sums of the costs of the best paths that reach a pixel
// from eight directions, where a step between neighbouring planes costs a little and a jump more.
#pragma once

#include "stereo/plane_sweep.h"

#include <span>
#include <vector>

namespace tetrec {

struct SemiGlobalOptions {
  int small_step = 12;  // P1: penalty of a step by one plane, in units of cost
  int jump = 90;        // P2: penalty of a jump in a surface without edges
  double edge = 20;     // P2 is divided by 1 + edge x the difference of grey values
};

// The best plane of each pixel, refined between planes by a parabola through the sums.
struct PlaneChoice {
  std::vector<float> plane;   // height x width; < 0: none (the best plane is the first or the last)
  std::vector<uint8_t> cost;  // height x width: of the best plane, before smoothing
};

// `grey`: height x width.
PlaneChoice ChooseSmoothPlanes(const CostVolume& volume, std::span<const float> grey, int planes,
                               const SemiGlobalOptions& options);

}  // namespace tetrec
