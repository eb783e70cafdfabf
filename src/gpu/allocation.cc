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

Allocation Allocate(const Device& device, const std::string& name, uint64_t bytes,
                    VkBufferUsageFlags usage, std::initializer_list<VkMemoryPropertyFlags> wishes) {
  Allocation result;
  VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
                          .size = bytes,
                          .usage = usage,
                          .sharingMode = VK_SHARING_MODE_EXCLUSIVE};
  TETREC_VK(vkCreateBuffer(device.handle, &info, nullptr, &result.buffer));
  VkMemoryRequirements needs;
  vkGetBufferMemoryRequirements(device.handle, result.buffer, &needs);
  int type = -1;
  for (VkMemoryPropertyFlags wish : wishes) {
    if (type < 0) type = FindMemoryType(device, needs.memoryTypeBits, wish);
  }
  VkResult status = VK_ERROR_OUT_OF_DEVICE_MEMORY;
  if (type >= 0) {
    VkMemoryAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO,
                                  .allocationSize = needs.size,
                                  .memoryTypeIndex = uint32_t(type)};
    status = vkAllocateMemory(device.handle, &allocate, nullptr, &result.memory);
  }
  if (status != VK_SUCCESS) {
    vkDestroyBuffer(device.handle, result.buffer, nullptr);
    throw EnvironmentError(fmt::format(
        "device '{}' has no memory for buffer '{}' of {} MiB: use fewer tets or smaller images",
        device.properties.deviceName, name, bytes >> 20));
  }
  TETREC_VK(vkBindBufferMemory(device.handle, result.buffer, result.memory, 0));
  const VkMemoryPropertyFlags flags = device.memory.memoryTypes[type].propertyFlags;
  if ((flags & kHostMemory) == kHostMemory) {
    TETREC_VK(vkMapMemory(device.handle, result.memory, 0, VK_WHOLE_SIZE, 0, &result.mapped));
  }
  return result;
}

void Free(const Device& device, const Allocation& allocation) {
  vkDestroyBuffer(device.handle, allocation.buffer, nullptr);
  vkFreeMemory(device.handle, allocation.memory, nullptr);
}

}  // namespace tetrec
