// A batch of rays on the device: where they go, what they meet, and their gradients of the loss.
#pragma once

#include "gpu/buffer.h"
#include "render/training_renderer.h"

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

  // Grows buffers that are too small. The device must not be using them.
  void SetBlocks(const Device& device, std::span<const RayBlock> ray_blocks);
};

}  // namespace tetrec
