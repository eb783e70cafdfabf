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
  // Blocks a row where the batch is a tile (a rectangle of one view, row of blocks by row), else 0.
  uint32_t columns = 0;

  // Grows the buffers where they are too small. The device must not be using them.
  void SetBlocks(const Device& device, std::span<const RayBlock> ray_blocks);
};

// 4 x 2 blocks that cover width x height, row of blocks by row.
std::vector<RayBlock> CoveringBlocks(int width, int height);

// Pixel (x, y) of ray `ray` of the batch of `blocks`.
glm::ivec2 PixelOfRay(std::span<const RayBlock> blocks, size_t ray);

}  // namespace tetrec
