// Device buffers that the host fills and reads.
#include "gpu/buffer.h"

#include "core/error.h"
#include "gpu/commands.h"
#include "gpu/staging.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace tetrec {
namespace {

uint32_t TexelBytes(VkFormat format) {
  switch (format) {
    case VK_FORMAT_R32G32B32A32_SFLOAT:
    case VK_FORMAT_R32G32B32A32_UINT:
      return 16;
    default:
      return 0;
  }
}

// The kinds of memory that suit a buffer, the best first.
std::initializer_list<VkMemoryPropertyFlags> WishesOf(BufferHome home) {
  static constexpr VkMemoryPropertyFlags kDevice = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  static constexpr std::initializer_list<VkMemoryPropertyFlags> kOfDevice = {
      kDevice | kCachedHostMemory, kDevice, kHostMemory};
  static constexpr std::initializer_list<VkMemoryPropertyFlags> kWritten = {
      kDevice | kCachedHostMemory, kDevice | kHostMemory, kHostMemory};
  static constexpr std::initializer_list<VkMemoryPropertyFlags> kRead = {
      kDevice | kCachedHostMemory, kCachedHostMemory, kHostMemory};
  switch (home) {
    case BufferHome::kDevice:
      return kOfDevice;
    case BufferHome::kHostWrites:
      return kWritten;
    case BufferHome::kHostReads:
      return kRead;
  }
  return kOfDevice;
}

}  // namespace

Buffer::Buffer(const Device& device, std::string name, uint64_t bytes, VkFormat texels,
               BufferHome home)
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
  memory_ = Allocation(device, name_, bytes_, usage, WishesOf(home));
  if (device.maps_buffers || home != BufferHome::kDevice) mapped_ = memory_.mapped();
  MemoryUse& use = *device.memory_use;
  use.bytes += bytes_;
  use.most_bytes = std::max(use.most_bytes, use.bytes);
  if (is_texel) {
    VkBufferViewCreateInfo view{.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                .buffer = handle(),
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
}

void Buffer::Swap(Buffer& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(name_, other.name_);
  std::swap(bytes_, other.bytes_);
  std::swap(memory_, other.memory_);
  std::swap(mapped_, other.mapped_);
  std::swap(view_, other.view_);
}

void Buffer::Upload(const void* source, uint64_t bytes, uint64_t offset) {
  TETREC_CHECK(offset + bytes <= bytes_, fmt::format("upload of {} bytes at {} into '{}' of {}",
                                                     bytes, offset, name_, bytes_));
  if (mapped_ != nullptr) {
    std::memcpy(static_cast<char*>(mapped_) + offset, source, bytes);
    return;
  }
  StagingOf(*device_).ToDevice(source, handle(), offset, bytes);
}

void Buffer::Download(void* destination, uint64_t bytes, uint64_t offset) const {
  TETREC_CHECK(offset + bytes <= bytes_, fmt::format("download of {} bytes at {} from '{}' of {}",
                                                     bytes, offset, name_, bytes_));
  if (mapped_ != nullptr) {
    std::memcpy(destination, static_cast<const char*>(mapped_) + offset, bytes);
    return;
  }
  StagingOf(*device_).FromDevice(handle(), offset, destination, bytes);
}

void Buffer::FillZero() {
  if (mapped_ != nullptr) {
    std::memset(mapped_, 0, bytes_);
    return;
  }
  CommandRecorder recorder(*device_);
  recorder.Begin();
  vkCmdFillBuffer(recorder.handle(), handle(), 0, VK_WHOLE_SIZE, 0);
  recorder.EndAndSubmit();
  recorder.Wait();
}

}  // namespace tetrec
