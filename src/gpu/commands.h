// Records dispatches into a command buffer, submits it, waits for it.
#pragma once

#include "gpu/buffer.h"
#include "gpu/program.h"

#include <set>
#include <span>
#include <vector>

namespace tetrec {

// Barriers are derived, not written by hand: the recorder keeps account of which buffers were read
// and written since the last barrier and puts one before a dispatch that would race.
// (Synchronization validation misses hazards between dispatches, so this account is the only
// guard.)
class CommandRecorder {
 public:
  explicit CommandRecorder(const Device& device);
  CommandRecorder(const CommandRecorder&) = delete;
  CommandRecorder& operator=(const CommandRecorder&) = delete;
  ~CommandRecorder();

  void Begin();
  // Runs ceil(threads / local_size) workgroups. `buffers` are in the order of program.bindings().
  template <class Push>
  void Dispatch(const Program& program, std::span<const Buffer* const> buffers, const Push& push,
                uint64_t threads, uint32_t local_size) {
    DispatchBytes(program, buffers, &push, sizeof(Push), threads, local_size);
  }
  void EndAndSubmit();
  // Until the submitted work is done; its writes are then visible to the host.
  void Wait();

  VkCommandBuffer handle() const { return handle_; }
  uint32_t barriers() const { return barriers_; }  // since Begin

 private:
  void DispatchBytes(const Program& program, std::span<const Buffer* const> buffers,
                     const void* push, uint32_t push_bytes, uint64_t threads, uint32_t local_size);
  void Barrier(VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access);

  const Device& device_;
  VkCommandBuffer handle_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  bool submitted_ = false;
  uint32_t barriers_ = 0;
  std::set<VkBuffer> read_, written_;
};

}  // namespace tetrec
