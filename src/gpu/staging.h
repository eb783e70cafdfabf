// Copies between the host and buffers that it cannot reach.
#pragma once

#include "gpu/allocation.h"
#include "gpu/commands.h"

#include <cstdint>

namespace tetrec {

// Host memory through which copies pass, one part at a time. It is kept because drivers take longer
// to allocate such memory than to copy a few megabytes.
class StagingArea {
 public:
  explicit StagingArea(const Device& device);
  StagingArea(const StagingArea&) = delete;
  StagingArea& operator=(const StagingArea&) = delete;
  // Both wait until all work that was submitted before, and the copy itself, are done.
  void ToDevice(const void* source, VkBuffer buffer, uint64_t offset, uint64_t bytes);
  void FromDevice(VkBuffer buffer, uint64_t offset, void* destination, uint64_t bytes);

 private:
  void Copy(VkBuffer from, uint64_t from_offset, VkBuffer to, uint64_t to_offset, uint64_t bytes);

  Allocation area_;
  CommandRecorder recorder_;
};

// Returns the staging area of the device. The first call creates it.
StagingArea& StagingOf(const Device& device);

}  // namespace tetrec
