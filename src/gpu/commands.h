// Records dispatches and draws into a command buffer, submits it, waits for it.
#pragma once

#include "gpu/buffer.h"
#include "gpu/program.h"

#include <set>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

// Pixels [x, x + width) x [y, y + height).
struct PixelRect {
  uint32_t x = 0, y = 0, width = 0, height = 0;
};

// A buffer for one of a kernel's bindings (kBind... in shaders/shared/gpu_types.glsl.h).
struct BoundBuffer {
  uint32_t binding;
  const Buffer* buffer;
  BoundBuffer(uint32_t number, const Buffer& for_binding) : binding(number), buffer(&for_binding) {}
};
using BoundBuffers = std::vector<BoundBuffer>;

// Barriers are derived, not written by hand: the recorder keeps track of the buffers that were read
// and written since the last barrier and inserts one before a command that would race.
// (Synchronization validation misses hazards between dispatches, so nothing else guards against
// them.)
class CommandRecorder {
 public:
  explicit CommandRecorder(const Device& device);
  CommandRecorder(const CommandRecorder&) = delete;
  CommandRecorder& operator=(const CommandRecorder&) = delete;
  ~CommandRecorder();

  void Begin();
  // Runs as many workgroups as `threads` threads need. `buffers` are in any order: one for each
  // binding that the kernel uses; those for bindings that it declares but does not use are ignored.
  // Throws BugError if one is missing, is of the wrong kind or is for a binding that the kernel
  // does not declare, or if the push constants differ in size.
  template <class Push>
  void Dispatch(const Program& program, const BoundBuffers& buffers, const Push& push,
                uint64_t threads) {
    DispatchBytes(program, buffers, &push, sizeof(Push), threads, false);
  }
  // Like Dispatch, for kernels that number their threads by ThreadIndex()
  // (shaders/thread_index.glsl): any number of workgroups, in rows that are as long as the device
  // allows (65,535 on some).
  template <class Push>
  void DispatchMany(const Program& program, const BoundBuffers& buffers, const Push& push,
                    uint64_t threads) {
    DispatchBytes(program, buffers, &push, sizeof(Push), threads, true);
  }
  // Like DispatchMany, with as many workgroups as the device itself has counted: three uint32_t at
  // the start of `groups`, rows second.
  template <class Push>
  void DispatchCounted(const Program& program, const BoundBuffers& buffers, const Push& push,
                       const Buffer& groups) {
    DispatchCountedBytes(program, buffers, &push, sizeof(Push), groups);
  }
  // Draws `vertices` vertices; clip space spans `viewport`, only pixels in `area` get fragments.
  template <class Push>
  void Draw(const Program& program, const BoundBuffers& buffers, const Push& push,
            uint32_t vertices, const PixelRect& viewport, const PixelRect& area) {
    DrawBytes(program, buffers, &push, sizeof(Push), vertices, viewport, area);
  }
  void FillZero(const Buffer& buffer);
  void EndAndSubmit();
  // Returns when the submitted work is done; its writes are then visible to the host.
  void Wait();

  VkCommandBuffer handle() const { return handle_; }
  uint32_t barriers() const { return barriers_; }  // since Begin

 private:
  void DispatchBytes(const Program& program, const BoundBuffers& buffers, const void* push,
                     uint32_t push_bytes, uint64_t threads, bool in_rows);
  void DispatchCountedBytes(const Program& program, const BoundBuffers& buffers, const void* push,
                            uint32_t push_bytes, const Buffer& groups);
  void DrawBytes(const Program& program, const BoundBuffers& buffers, const void* push,
                 uint32_t push_bytes, uint32_t vertices, const PixelRect& viewport,
                 const PixelRect& area);
  // Records a barrier if one is needed, the pipeline, the buffers and the push constants.
  void Bind(const Program& program, const BoundBuffers& buffers, const void* push,
            uint32_t push_bytes);
  VkPipelineStageFlags2 WorkStages() const;
  void BeginTiming();
  // To be called after a command.
  void WriteTimestamp(const std::string& name);
  // Reads the times of a submission that is done.
  void CollectTimes();
  void WorkBarrier();
  void Barrier(VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access);

  const Device& device_;
  VkCommandBuffer handle_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  bool submitted_ = false;
  bool has_new_kernels_ = false;  // since the last Wait
  uint32_t barriers_ = 0;
  std::set<VkBuffer> read_, written_;
  // For Device::kernel_times: one timestamp before the first command and one after each.
  VkQueryPool queries_ = VK_NULL_HANDLE;
  uint32_t query_capacity_ = 0;
  std::vector<std::string> timed_;  // names of the commands since Begin
};

}  // namespace tetrec
