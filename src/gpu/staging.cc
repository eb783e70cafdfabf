// Copies between the host and buffers that it cannot reach.
#include "gpu/staging.h"

#include <algorithm>
#include <cstring>

namespace tetrec {
namespace {

constexpr uint64_t kStagingBytes = 16ull << 20;

}  // namespace

StagingArea::StagingArea(const Device& device)
    : area_(device, "staging", kStagingBytes,
            VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
            {kCachedHostMemory, kHostMemory}),
      recorder_(device) {}

void StagingArea::ToDevice(const void* source, VkBuffer buffer, uint64_t offset, uint64_t bytes) {
  for (uint64_t at = 0; at < bytes; at += kStagingBytes) {
    const uint64_t part = std::min(kStagingBytes, bytes - at);
    std::memcpy(area_.mapped(), static_cast<const char*>(source) + at, part);
    Copy(area_.buffer(), 0, buffer, offset + at, part);
  }
}

void StagingArea::FromDevice(VkBuffer buffer, uint64_t offset, void* destination, uint64_t bytes) {
  for (uint64_t at = 0; at < bytes; at += kStagingBytes) {
    const uint64_t part = std::min(kStagingBytes, bytes - at);
    Copy(buffer, offset + at, area_.buffer(), 0, part);
    std::memcpy(static_cast<char*>(destination) + at, area_.mapped(), part);
  }
}

void StagingArea::Copy(VkBuffer from, uint64_t from_offset, VkBuffer to, uint64_t to_offset,
                       uint64_t bytes) {
  recorder_.Begin();
  const VkBufferCopy region{.srcOffset = from_offset, .dstOffset = to_offset, .size = bytes};
  vkCmdCopyBuffer(recorder_.handle(), from, to, 1, &region);
  recorder_.EndAndSubmit();
  recorder_.Wait();
}

StagingArea& StagingOf(const Device& device) {
  if (!device.staging) device.staging = std::make_unique<StagingArea>(device);
  return *device.staging;
}

}  // namespace tetrec
