// A batch of rays on the device: where they go, what they meet, and their gradients of the loss.
#pragma once

#include "gpu/buffer.h"
#include "render/training_renderer.h"
#include "shared/gpu_types.glsl.h"

#include <vector>

namespace tetrec {

struct RayBatch {
  Buffer blocks;          // one GpuBlock per 8 rays
  Buffer colors;          // vec4 per ray: colour before the background | optical depth
  Buffer entries;         // uvec2 per ray: the integrator's own
  Buffer gradients;       // vec4 per ray: dL/dcolour | dL/dtransmittance
  Buffer partial_losses;  // vec2 per workgroup: loss, squared error
  Buffer exposure_sums;   // vec4 x 4 per block; empty until a batch asks for them
  // The views of the blocks whose exposure sums are yet to be read.
  std::vector<uint32_t> summed_views;
  uint32_t capacity = 0;  // rays
  uint32_t count = 0;     // rays
  uint32_t columns = 0;   // TileColumns
  Buffer centers;         // vec4 per slot: camera centre of its view
  uint32_t slots = 0;     // views in the batch

  // Grows buffers that are too small. The device must not be using them. `views` has those to which
  // the blocks refer.
  void SetBlocks(const Device& device, std::span<const RayBlock> ray_blocks,
                 std::span<const gpu_types::GpuView> views);
};

}  // namespace tetrec
