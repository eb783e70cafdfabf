// Memory of a device for one buffer.
#pragma once

#include "gpu/device.h"

#include <cstdint>
#include <initializer_list>
#include <string>

namespace tetrec {

// Memory that the host can map and need not flush.
inline constexpr VkMemoryPropertyFlags kHostMemory =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
inline constexpr VkMemoryPropertyFlags kCachedHostMemory =
    kHostMemory | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;

// A Vulkan buffer with memory of its own.
struct Allocation {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  void* mapped = nullptr;  // null unless the host can reach it
};

// Takes memory of the first of the `wishes` that the device has. Throws EnvironmentError, which
// names the buffer, if there is none left. `name` is for that message only.
Allocation Allocate(const Device& device, const std::string& name, uint64_t bytes,
                    VkBufferUsageFlags usage, std::initializer_list<VkMemoryPropertyFlags> wishes);
void Free(const Device& device, const Allocation& allocation);

}  // namespace tetrec
