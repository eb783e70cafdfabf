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

// Drops the depths that fewer than `least` other views confirm; returns how many are left.
uint64_t KeepAgreed(StereoDepth& map, int least);

// Drops patches of fewer than `least` pixels, which agree by chance in the sky, in front of
// repeated texture and beyond the farthest plane; returns how many depths are left. A patch
// consists of pixels that touch, at a side or a corner, and whose depths differ by at most
// `tolerance` (relative) from one to the next.
uint64_t KeepPatches(StereoDepth& map, size_t least, double tolerance);

}  // namespace tetrec
