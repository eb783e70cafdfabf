// Device buffers that the host fills and reads.
#include "gpu/buffer.h"

#include "core/error.h"
#include "gpu/commands.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace tetrec {
namespace {

uint32_t TexelBytes(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R8G8B8A8_UNORM:
      return 4;
    case VK_FORMAT_R32G32B32A32_SFLOAT:
    case VK_FORMAT_R32G32B32A32_UINT:
      return 16;
    default:
      return 0;
  }
}

// A memory type among `allowed` that has all `wanted` flags; -1 if there is none.
int FindMemoryType(const Device& device, uint32_t allowed, VkMemoryPropertyFlags wanted) {
  for (uint32_t i = 0; i < device.memory.memoryTypeCount; ++i) {
    const bool fits = (device.memory.memoryTypes[i].propertyFlags & wanted) == wanted;
    if ((allowed >> i & 1u) && fits) return int(i);
  }
  return -1;
}

constexpr VkMemoryPropertyFlags kHost =
    VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;

struct Allocation {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  void* mapped = nullptr;
};

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
  if ((flags & kHost) == kHost) {
    TETREC_VK(vkMapMemory(device.handle, result.memory, 0, VK_WHOLE_SIZE, 0, &result.mapped));
  }
  return result;
}

// A host-visible copy of part of a buffer, for devices that have their own memory.
class Staging {
 public:
  Staging(const Device& device, uint64_t bytes)
      : device_(device),
        allocation_(Allocate(device, "staging", bytes,
                             VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                             {kHost | VK_MEMORY_PROPERTY_HOST_CACHED_BIT, kHost})) {}
  ~Staging() {
    vkDestroyBuffer(device_.handle, allocation_.buffer, nullptr);
    vkFreeMemory(device_.handle, allocation_.memory, nullptr);
  }
  void Copy(VkBuffer from, uint64_t from_offset, VkBuffer to, uint64_t to_offset, uint64_t bytes) {
    CommandRecorder recorder(device_);
    recorder.Begin();
    const VkBufferCopy region{.srcOffset = from_offset, .dstOffset = to_offset, .size = bytes};
    vkCmdCopyBuffer(recorder.handle(), from, to, 1, &region);
    recorder.EndAndSubmit();
    recorder.Wait();
  }
  VkBuffer handle() const { return allocation_.buffer; }
  void* mapped() const { return allocation_.mapped; }

 private:
  const Device& device_;
  Allocation allocation_;
};

}  // namespace

Buffer::Buffer(const Device& device, std::string name, uint64_t bytes, VkFormat texels)
    : device_(&device), name_(std::move(name)), bytes_(std::max<uint64_t>(bytes, 16)) {
  const VkPhysicalDeviceLimits& limits = device.properties.limits;
  const bool is_texel = texels != VK_FORMAT_UNDEFINED;
  const uint64_t limit = is_texel ? uint64_t(limits.maxTexelBufferElements) * TexelBytes(texels)
                                  : limits.maxStorageBufferRange;
  if (bytes_ > limit) {
    throw EnvironmentError(fmt::format(
        "buffer '{}' needs {} MiB; device '{}' allows {} MiB per buffer: use fewer tets "
        "or smaller images",
        name_, bytes_ >> 20, device.properties.deviceName, limit >> 20));
  }
  VkBufferUsageFlags usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                             VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT |
                             VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  if (is_texel) usage |= VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
  const Allocation allocation =
      Allocate(device, name_, bytes_, usage,
               {VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | kHost | VK_MEMORY_PROPERTY_HOST_CACHED_BIT,
                VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, kHost});
  handle_ = allocation.buffer;
  memory_ = allocation.memory;
  mapped_ = allocation.mapped;
  MemoryUse& use = *device.memory_use;
  use.bytes += bytes_;
  use.most_bytes = std::max(use.most_bytes, use.bytes);
  if (is_texel) {
    VkBufferViewCreateInfo view{.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                .buffer = handle_,
                                .format = texels,
                                .offset = 0,
                                .range = VK_WHOLE_SIZE};
    TETREC_VK(vkCreateBufferView(device.handle, &view, nullptr, &view_));
  }
}

Buffer::~Buffer() {
  if (device_ == nullptr) return;
  device_->memory_use->bytes -= bytes_;
  vkDestroyBufferView(device_->handle, view_, nullptr);
  vkDestroyBuffer(device_->handle, handle_, nullptr);
  vkFreeMemory(device_->handle, memory_, nullptr);
}

void Buffer::Swap(Buffer& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(name_, other.name_);
  std::swap(bytes_, other.bytes_);
  std::swap(handle_, other.handle_);
  std::swap(memory_, other.memory_);
  std::swap(view_, other.view_);
  std::swap(mapped_, other.mapped_);
}

void Buffer::Upload(const void* source, uint64_t bytes, uint64_t offset) {
  TETREC_CHECK(offset + bytes <= bytes_, fmt::format("upload of {} bytes at {} into '{}' of {}",
                                                     bytes, offset, name_, bytes_));
  if (mapped_ != nullptr) {
    std::memcpy(static_cast<char*>(mapped_) + offset, source, bytes);
    return;
  }
  Staging staging(*device_, bytes);
  std::memcpy(staging.mapped(), source, bytes);
  staging.Copy(staging.handle(), 0, handle_, offset, bytes);
}

void Buffer::Download(void* destination, uint64_t bytes, uint64_t offset) const {
  TETREC_CHECK(offset + bytes <= bytes_, fmt::format("download of {} bytes at {} from '{}' of {}",
                                                     bytes, offset, name_, bytes_));
  if (mapped_ != nullptr) {
    std::memcpy(destination, static_cast<const char*>(mapped_) + offset, bytes);
    return;
  }
  Staging staging(*device_, bytes);
  staging.Copy(handle_, offset, staging.handle(), 0, bytes);
  std::memcpy(destination, staging.mapped(), bytes);
}

void Buffer::FillZero() {
  if (mapped_ != nullptr) {
    std::memset(mapped_, 0, bytes_);
    return;
  }
  CommandRecorder recorder(*device_);
  recorder.Begin();
  vkCmdFillBuffer(recorder.handle(), handle_, 0, VK_WHOLE_SIZE, 0);
  recorder.EndAndSubmit();
  recorder.Wait();
}

}  // namespace tetrec
