// Memory of a device for one buffer.
#pragma once

#include "gpu/device.h"

#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>

namespace tetrec {

// Memory that the host can map and need not flush.
inline constexpr VkMemoryPropertyFlags kHostMemory =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
inline constexpr VkMemoryPropertyFlags kCachedHostMemory =
    kHostMemory | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;

// Owns a Vulkan buffer and the memory behind it.
class Allocation {
 public:
  Allocation() = default;
  // Takes memory of the first of the `wishes` of which the device has enough. Throws
  // EnvironmentError, which names the buffer, if there is none. `name` is for that message only.
  Allocation(const Device& device, const std::string& name, uint64_t bytes,
             VkBufferUsageFlags usage, std::initializer_list<VkMemoryPropertyFlags> wishes);
  Allocation(Allocation&& other) noexcept { std::swap(own_, other.own_); }
  Allocation& operator=(Allocation&& other) noexcept {
    std::swap(own_, other.own_);
    return *this;
  }
  ~Allocation();

  VkBuffer buffer() const { return own_.buffer; }
  void* mapped() const { return own_.mapped; }  // null unless the host can reach it

 private:
  // False if there is no memory of this kind, or not enough.
  bool TakeMemory(uint64_t bytes, int type);

  struct {
    const Device* device = nullptr;
    VkBuffer buffer = VK_NULL_HANDLE;
    VkDeviceMemory memory = VK_NULL_HANDLE;
    void* mapped = nullptr;
  } own_;
};

}  // namespace tetrec
