// The scene of the march benchmarks: the ball on about 110,000 tets, seen from all around.
#pragma once

#include "benchmark/bench_scene.h"
#include "render/ray_blocks.h"

namespace tetrec {

constexpr int kPicture = 256;  // [px] per side
constexpr int kViews = 32;
constexpr int kGrid = 26;  // jittered points per side, 17,576 in total

inline std::vector<RayBlock> AllBlocks(uint32_t view = 0) {
  return CoveringBlocks(kPicture, kPicture, view);
}

}  // namespace tetrec
