// A batch of rays on the device.
#include "render/ray_batch.h"

#include "shared/gpu_types.glsl.h"

namespace tetrec {

static_assert(sizeof(RayBlock) == sizeof(gpu_types::GpuBlock));
static_assert(kRayBlockWidth == kBlockWidth && kRayBlockHeight == kBlockHeight &&
              kRaysPerBlock == kBlockRays);

namespace {

// Blocks a row of a rectangle of blocks of one view, row by row; 0 where it is none.
uint32_t ColumnsOf(std::span<const RayBlock> blocks) {
  if (blocks.empty()) return 0;
  const RayBlock& first = blocks[0];
  size_t columns = 1;
  while (columns < blocks.size() && blocks[columns].y == first.y) ++columns;
  if (blocks.size() % columns != 0) return 0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    const bool in_place = blocks[i].view == first.view &&
                          blocks[i].x == first.x + i % columns * kRayBlockWidth &&
                          blocks[i].y == first.y + i / columns * kRayBlockHeight;
    if (!in_place) return 0;
  }
  return uint32_t(columns);
}

}  // namespace

void RayBatch::SetBlocks(const Device& device, std::span<const RayBlock> ray_blocks) {
  count = uint32_t(ray_blocks.size()) * kRaysPerBlock;
  columns = ColumnsOf(ray_blocks);
  if (count > capacity) {
    const uint64_t rays = count;
    blocks = Buffer(device, "ray blocks", ray_blocks.size_bytes());
    colors = Buffer(device, "ray colors", rays * 16);
    entries = Buffer(device, "ray entries", rays * 8);
    gradients = Buffer(device, "ray gradients", rays * 16);
    partial_losses =
        Buffer(device, "partial losses", (rays + kWorkgroupSize - 1) / kWorkgroupSize * 8);
    capacity = count;
  }
  blocks.Upload(ray_blocks.data(), ray_blocks.size_bytes());
}

std::vector<RayBlock> CoveringBlocks(int width, int height) {
  std::vector<RayBlock> blocks;
  for (int y = 0; y < height; y += kRayBlockHeight) {
    for (int x = 0; x < width; x += kRayBlockWidth) {
      blocks.push_back({0, uint32_t(x), uint32_t(y)});
    }
  }
  return blocks;
}

glm::ivec2 PixelOfRay(std::span<const RayBlock> blocks, size_t ray) {
  const RayBlock& block = blocks[ray / kRaysPerBlock];
  const int lane = int(ray % kRaysPerBlock);
  return {int(block.x) + lane % kRayBlockWidth, int(block.y) + lane / kRayBlockWidth};
}

}  // namespace tetrec
