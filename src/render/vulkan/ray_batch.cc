// A batch of rays on the device.
#include "render/vulkan/ray_batch.h"

#include "render/ray_blocks.h"
#include "shared/gpu_types.glsl.h"

namespace tetrec {

static_assert(sizeof(RayBlock) == sizeof(gpu_types::GpuBlock));
static_assert(kRayBlockWidth == kBlockWidth && kRayBlockHeight == kBlockHeight &&
              kRaysPerBlock == kBlockRays);

namespace {

// Numbers the views of the blocks in order of their first blocks, and sets the blocks' slots.
// Returns the views by slot.
std::vector<uint32_t> NumberViews(std::vector<RayBlock>& blocks, size_t view_count) {
  constexpr uint32_t kNone = 0xFFFFFFFFu;
  std::vector<uint32_t> slot_of_view(view_count, kNone), views;
  for (RayBlock& block : blocks) {
    uint32_t& slot = slot_of_view[block.view];
    if (slot == kNone) {
      slot = uint32_t(views.size());
      views.push_back(block.view);
    }
    block.slot = slot;
  }
  return views;
}

}  // namespace

void RayBatch::SetBlocks(const Device& device, std::span<const RayBlock> ray_blocks,
                         std::span<const gpu_types::GpuView> views) {
  count = uint32_t(ray_blocks.size()) * kRaysPerBlock;
  columns = TileColumns(ray_blocks);
  if (count > capacity) {
    const uint64_t rays = count;
    blocks = Buffer(device, "ray blocks", ray_blocks.size_bytes(), VK_FORMAT_R32G32B32A32_UINT,
                    BufferHome::kHostWrites);
    colors = Buffer(device, "ray colors", rays * 16);
    entries = Buffer(device, "ray entries", rays * 8);
    gradients = Buffer(device, "ray gradients", rays * 16);
    partial_losses =
        Buffer(device, "partial losses", (rays + kWorkgroupSize - 1) / kWorkgroupSize * 8,
               VK_FORMAT_UNDEFINED, BufferHome::kHostReads);
    capacity = count;
  }
  std::vector<RayBlock> numbered(ray_blocks.begin(), ray_blocks.end());
  std::vector<glm::vec4> slot_centers;
  for (const uint32_t view : NumberViews(numbered, views.size())) {
    slot_centers.push_back(views[view].center_in_world_cy);
  }
  slots = uint32_t(slot_centers.size());
  if (centers.bytes() < slot_centers.size() * sizeof(glm::vec4)) {
    centers = Buffer(device, "camera centers", slot_centers.size() * sizeof(glm::vec4),
                     VK_FORMAT_R32G32B32A32_SFLOAT, BufferHome::kHostWrites);
  }
  centers.Upload(slot_centers);
  blocks.Upload(numbered);
}

}  // namespace tetrec
