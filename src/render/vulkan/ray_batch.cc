// A batch of rays on the device.
#include "render/vulkan/ray_batch.h"

#include "render/ray_blocks.h"
#include "shared/gpu_types.glsl.h"

namespace tetrec {

static_assert(sizeof(RayBlock) == sizeof(gpu_types::GpuBlock));
static_assert(kRayBlockWidth == kBlockWidth && kRayBlockHeight == kBlockHeight &&
              kRaysPerBlock == kBlockRays);

void RayBatch::SetBlocks(const Device& device, std::span<const RayBlock> ray_blocks) {
  count = uint32_t(ray_blocks.size()) * kRaysPerBlock;
  columns = TileColumns(ray_blocks);
  if (count > capacity) {
    const uint64_t rays = count;
    blocks = Buffer(device, "ray blocks", ray_blocks.size_bytes(), VK_FORMAT_R32G32B32A32_UINT);
    colors = Buffer(device, "ray colors", rays * 16);
    entries = Buffer(device, "ray entries", rays * 8);
    gradients = Buffer(device, "ray gradients", rays * 16);
    partial_losses =
        Buffer(device, "partial losses", (rays + kWorkgroupSize - 1) / kWorkgroupSize * 8);
    capacity = count;
  }
  blocks.Upload(ray_blocks.data(), ray_blocks.size_bytes());
}

}  // namespace tetrec
