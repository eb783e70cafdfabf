// Memory of a device for one buffer.
#include "gpu/allocation.h"

#include "core/error.h"

#include <fmt/format.h>

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
                       std::initializer_list<VkMemoryPropertyFlags> wishes) {
  own_.device = &device;
  VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                          .size = bytes,
                          .usage = usage,
                          .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
  TETREC_VK(vkCreateBuffer(device.handle, &info, nullptr, &own_.buffer));
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device.handle, own_.buffer, &needs);
  // Memory of the device that the host can reach is scarce on many GPUs.
  int type = -1;
  for (const VkMemoryPropertyFlags wish : wishes) {
    type = FindMemoryType(device, needs.memoryTypeBits, wish);
    if (TakeMemory(needs.size, type)) break;
  }
  if (own_.memory == VK_NULL_HANDLE) {
    vkDestroyBuffer(device.handle, own_.buffer, nullptr);
    throw EnvironmentError(fmt::format(
        "device '{}' has no memory for buffer '{}' of {} MiB: use fewer tets or smaller images",
        device.properties.deviceName, name, bytes >> 20));
  }
  TETREC_VK(vkBindBufferMemory(device.handle, own_.buffer, own_.memory, 0));
  const VkMemoryPropertyFlags flags = device.memory.memoryTypes[type].propertyFlags;
  if ((flags & kHostMemory) == kHostMemory) {
    TETREC_VK(vkMapMemory(device.handle, own_.memory, 0, VK_WHOLE_SIZE, 0, &own_.mapped));
  }
}

bool Allocation::TakeMemory(uint64_t bytes, int type) {
  if (type < 0) return false;
  const VkMemoryAllocateInfo info{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .allocationSize = bytes,
                                  .memoryTypeIndex = uint32_t(type)};
  return vkAllocateMemory(own_.device->handle, &info, nullptr, &own_.memory) == VK_SUCCESS;
}

Allocation::~Allocation() {
  if (own_.device == nullptr) return;
  vkDestroyBuffer(own_.device->handle, own_.buffer, nullptr);
  vkFreeMemory(own_.device->handle, own_.memory, nullptr);
}

}  // namespace tetrec
