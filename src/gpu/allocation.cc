// Memory of a device for one buffer.
#include "gpu/allocation.h"

#include "core/error.h"

#include <fmt/format.h>

#include <utility>

namespace tetrec {
namespace {

// A memory type among `allowed` that has all `wanted` flags; -1 if there is none.
int FindMemoryType(const Device& device, uint32_t allowed, VkMemoryPropertyFlags wanted) {
  for (uint32_t i = 0; i < device.memory.memoryTypeCount; ++i) {
    const bool fits = (device.memory.memoryTypes[i].propertyFlags & wanted) == wanted;
    if ((allowed >> i & 1u) && fits) return int(i);
  }
  return -1;
}

}  // namespace

Allocation::Allocation(const Device& device, const std::string& name, uint64_t bytes,
                       VkBufferUsageFlags usage,
                       std::initializer_list<VkMemoryPropertyFlags> wishes)
    : device_(&device) {
  VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                          .size = bytes,
                          .usage = usage,
                          .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
  TETREC_VK(vkCreateBuffer(device.handle, &info, nullptr, &buffer_));
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device.handle, buffer_, &needs);
  // Memory of the device that the host can reach is scarce on many GPUs.
  int type = -1;
  for (const VkMemoryPropertyFlags wish : wishes) {
    type = FindMemoryType(device, needs.memoryTypeBits, wish);
    if (TakeMemory(needs.size, type)) break;
  }
  if (memory_ == VK_NULL_HANDLE) {
    vkDestroyBuffer(device.handle, buffer_, nullptr);
    throw EnvironmentError(fmt::format(
        "device '{}' has no memory for buffer '{}' of {} MiB: use fewer tets or smaller images",
        device.properties.deviceName, name, bytes >> 20));
  }
  TETREC_VK(vkBindBufferMemory(device.handle, buffer_, memory_, 0));
  const VkMemoryPropertyFlags flags = device.memory.memoryTypes[type].propertyFlags;
  if ((flags & kHostMemory) == kHostMemory) {
    TETREC_VK(vkMapMemory(device.handle, memory_, 0, VK_WHOLE_SIZE, 0, &mapped_));
  }
}

bool Allocation::TakeMemory(uint64_t bytes, int type) {
  if (type < 0) return false;
  const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .allocationSize = bytes,
                                  .memoryTypeIndex = uint32_t(type)};
  return vkAllocateMemory(device_->handle, &info, nullptr, &memory_) == VK_SUCCESS;
}

Allocation::~Allocation() {
  if (device_ == nullptr) return;
  vkDestroyBuffer(device_->handle, buffer_, nullptr);
  vkFreeMemory(device_->handle, memory_, nullptr);
}

void Allocation::Swap(Allocation& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(buffer_, other.buffer_);
  std::swap(memory_, other.memory_);
  std::swap(mapped_, other.mapped_);
}

}  // namespace tetrec
