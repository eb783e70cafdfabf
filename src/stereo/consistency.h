// Depths that other views confirm.
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

uint64_t CountDepths(const StereoDepth& map);

// The share of all depths that two other views or more confirm; 1 without depths. Where photos are
// far apart it is small, because two others seldom see the same surface.
double ShareConfirmedByTwo(std::span<const StereoDepth> maps);

// How many other views must confirm a depth: two if two confirm at least half of all depths,
// otherwise one.
int ViewsToConfirm(std::span<const StereoDepth> maps);

// Keeps the depths that at least `least_views` other views (1 or more) confirm, in patches with
// enough evidence: the sum over a patch of the squared numbers of views that confirm its pixels is
// at least `least_evidence`. A wrong depth may agree with one other view's by chance, as in the sky
// or on a repeated texture, but seldom with several views', or over many pixels. A patch consists
// of pixels that touch, at a side or a corner, and whose depths differ by at most `tolerance` of
// the greater one from one to the next. Returns how many depths are left.
uint64_t KeepConfirmed(StereoDepth& map, int least_views, int least_evidence, double tolerance);

}  // namespace tetrec
