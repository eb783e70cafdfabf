// What the benchmarks of the march look at: the ball on about 110,000 tets, from all around.
#pragma once

#include "bench/bench_scene.h"
#include "render/ray_blocks.h"

namespace tetrec {

constexpr int kPicture = 256;  // [px] a side
constexpr int kViews = 32;
constexpr int kGrid = 26;  // jittered points a side: 17,576

inline std::vector<RayBlock> AllBlocks(uint32_t view = 0) {
  return CoveringBlocks(kPicture, kPicture, view);
}

}  // namespace tetrec
