// How far a kernel's loop may go: llvmpipe ends the loops of an invocation after a fixed number of
// rounds (MostLoopRounds), so whoever walks a long list or a long ray must stay below it.
#pragma once

#include "gpu/device.h"
#include "render/renderer.h"

#include <cstdint>

namespace tetrec {

// What a loop spends on one item (a tet, a fragment) at most. The parts of a split segment are
// added to it.
struct LoopCost {
  uint32_t rounds;  // of loops, its own and those nested in it
  uint32_t sums;    // that it adds to (shaders/atomic_sum.glsl)
};

// Items that one invocation can process.
uint32_t MostItems(const Device& device, const RendererOptions& options, LoopCost of_item);

}  // namespace tetrec
