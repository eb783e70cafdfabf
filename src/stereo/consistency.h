// Depths that several views agree on.
#pragma once

#include "run/stereo_depth.h"
#include "stereo/stereo_view.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// For each pixel with a depth, counts the views of `others` (indices into `views`, by map) whose
// own depth there has an inverse that differs by at most `tolerance` of it, and moves the inverse
// depth to the mean of those that agree. `maps` and `views` correspond. Depths are kept whatever
// the count is.
std::vector<StereoDepth> CountAgreement(std::span<const StereoDepth> maps,
                                        std::span<const StereoView> views,
                                        std::span<const std::vector<uint32_t>> others,
                                        double tolerance);

// Keeps the depths that other views confirm, in patches with enough evidence: the sum over a patch
// of the squared numbers of views that confirm its pixels is at least `least_evidence`. A wrong
// depth agrees with that of one other view by chance, in the sky or in front of repeated texture,
// but seldom with those of several, or over many pixels. A patch consists of pixels that touch, at
// a side or a corner, and whose depths differ by at most `tolerance` (relative) from one to the
// next. Returns how many depths are left.
uint64_t KeepConfirmed(StereoDepth& map, int least_evidence, double tolerance);

}  // namespace tetrec
