// How far a kernel's loop may go.
#include "render/vulkan/loop_bound.h"

namespace tetrec {
namespace {

// Rounds that adding to a sum takes: one in fixed point, none by native float atomics, and up to 9
// by compare and swap.
uint32_t RoundsOfSum(const Device& device, const RendererOptions& options) {
  if (options.deterministic) return 1;
  return device.has_float_atomics ? 0 : 9;
}

}  // namespace

uint32_t MostItems(const Device& device, const RendererOptions& options, LoopCost of_item) {
  const bool is_split = options.integral.kind == IntegralKind::kSplit;
  const uint32_t parts = is_split ? uint32_t(options.integral.splits) : 0;
  return MostLoopRounds(device) /
         (of_item.rounds + parts + of_item.sums * RoundsOfSum(device, options));
}

}  // namespace tetrec
