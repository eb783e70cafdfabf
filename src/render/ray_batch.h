// A batch of rays on the device: where they run, what they met, what the loss wants of them.
#pragma once

#include "gpu/buffer.h"
#include "render/renderer.h"

#include <vector>

namespace tetrec {

struct RayBatch {
  Buffer blocks;          // GpuBlock, one for 8 rays
  Buffer colors;          // vec4 a ray: colour before the background | optical depth
  Buffer entries;         // uvec2 a ray: the march's way into the mesh
  Buffer gradients;       // vec4 a ray: dL/dcolour | dL/dtransmittance
  Buffer partial_losses;  // vec2 a workgroup: loss, squared error
  uint32_t capacity = 0;  // rays
  uint32_t count = 0;     // rays
  uint32_t columns = 0;   // TileColumns

  // Grows the buffers where they are too small. The device must not be using them.
  void SetBlocks(const Device& device, std::span<const RayBlock> ray_blocks);
};

}  // namespace tetrec
