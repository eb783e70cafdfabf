// What the plane sweep and the slanted planes share: costs of 1 - correlation, of several
// neighbours.
#pragma once

#include <cstddef>

namespace tetrec {

// Added to both variances: windows whose grey values differ by less than about 1/256 correlate with
// nothing.
inline constexpr float kNoiseVariance = 2e-5f;
// The cost where a neighbour does not see the pixel; above every other.
inline constexpr float kUnseen = 4.0f;

// One cost from the best and the second best of several neighbours: with one or two neighbours the
// best, with more the mean of both, because the others may not see the pixel.
inline float CostOfNeighbors(float best, float second, size_t neighbors) {
  return neighbors > 2 && second < kUnseen ? 0.5f * (best + second) : best;
}

}  // namespace tetrec
