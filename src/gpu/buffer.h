// Device buffers that the host fills and reads.
#pragma once

#include "gpu/allocation.h"

#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace tetrec {

// Where a buffer lives if the device has memory of its own.
enum class BufferHome {
  kDevice,      // with the device, which reaches it fastest; the host's transfers wait for a copy
  kHostWrites,  // where the host writes directly, for small inputs of each step
  kHostReads,   // where the host reads directly, for small results of each step
};

// Owns its memory. It is mapped if the device's memory is the host's (software and integrated
// devices) or its home is not the device; otherwise transfers go through a staging area.
class Buffer {
 public:
  Buffer() = default;
  // `texels` is the format in which kernels read it as a texel buffer, or VK_FORMAT_UNDEFINED.
  Buffer(const Device& device, std::string name, uint64_t bytes,
         VkFormat texels = VK_FORMAT_UNDEFINED, BufferHome home = BufferHome::kDevice);
  Buffer(Buffer&& other) noexcept { Swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    Swap(other);
    return *this;
  }
  ~Buffer();

  VkBuffer handle() const { return memory_.buffer(); }
  VkBufferView view() const { return view_; }
  uint64_t bytes() const { return bytes_; }
  const std::string& name() const { return name_; }

  // Copy between host and device; the device must not be using the buffer.
  void Upload(const void* source, uint64_t bytes, uint64_t offset = 0);
  void Download(void* destination, uint64_t bytes, uint64_t offset = 0) const;
  void FillZero();

  template <class T>
  void Upload(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (!values.empty()) Upload(values.data(), values.size() * sizeof(T));
  }
  template <class T>
  std::vector<T> DownloadAs(uint64_t count) const {
    static_assert(std::is_trivially_copyable_v<T>);
    std::vector<T> values(count);
    if (count > 0) Download(values.data(), count * sizeof(T));
    return values;
  }

 private:
  void Swap(Buffer& other) noexcept;

  const Device* device_ = nullptr;
  std::string name_;
  uint64_t bytes_ = 0;
  Allocation memory_;
  void* mapped_ = nullptr;  // null where transfers go through the staging area
  VkBufferView view_ = VK_NULL_HANDLE;
};

// A buffer filled with values; never empty, because Vulkan has no empty buffers.
template <class T>
Buffer MakeBuffer(const Device& device, std::string name, const std::vector<T>& values,
                  VkFormat texels = VK_FORMAT_UNDEFINED) {
  Buffer buffer(device, std::move(name), values.size() * sizeof(T), texels);
  buffer.Upload(values);
  return buffer;
}

// Replaces a buffer that has fewer bytes; its contents are lost. The device must be done with it.
inline void Grow(const Device& device, Buffer& buffer, const char* name, uint64_t bytes,
                 BufferHome home = BufferHome::kDevice) {
  if (buffer.bytes() > 0 && buffer.bytes() >= bytes) return;
  buffer = {};  // frees the old one before the new one takes memory
  buffer = Buffer(device, name, bytes, VK_FORMAT_UNDEFINED, home);
}

}  // namespace tetrec
