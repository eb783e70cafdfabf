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

// Barriers are derived, not written by hand: the recorder keeps account of which buffers were read
// and written since the last barrier and puts one before a command that would race.
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
    DispatchBytes(program, buffers, &push, sizeof(Push), threads, local_size, false);
  }
  // As Dispatch for kernels that number their threads by ThreadIndex() (shaders/thread_index.glsl):
  // any number of workgroups, in rows of as many as the device takes (65,535 on some).
  template <class Push>
  void DispatchMany(const Program& program, std::span<const Buffer* const> buffers,
                    const Push& push, uint64_t threads, uint32_t local_size) {
    DispatchBytes(program, buffers, &push, sizeof(Push), threads, local_size, true);
  }
  // Draws `vertices` vertices; clip space spans `viewport`, only pixels in `area` get fragments.
  template <class Push>
  void Draw(const Program& program, std::span<const Buffer* const> buffers, const Push& push,
            uint32_t vertices, const PixelRect& viewport, const PixelRect& area) {
    DrawBytes(program, buffers, &push, sizeof(Push), vertices, viewport, area);
  }
  void FillZero(const Buffer& buffer);
  void EndAndSubmit();
  // Until the submitted work is done; its writes are then visible to the host.
  void Wait();

  VkCommandBuffer handle() const { return handle_; }
  uint32_t barriers() const { return barriers_; }  // since Begin

 private:
  void DispatchBytes(const Program& program, std::span<const Buffer* const> buffers,
                     const void* push, uint32_t push_bytes, uint64_t threads, uint32_t local_size,
                     bool in_rows);
  void DrawBytes(const Program& program, std::span<const Buffer* const> buffers, const void* push,
                 uint32_t push_bytes, uint32_t vertices, const PixelRect& viewport,
                 const PixelRect& area);
  // Barrier where it is needed, pipeline, buffers, push constants.
  void Bind(const Program& program, std::span<const Buffer* const> buffers, const void* push,
            uint32_t push_bytes);
  VkPipelineStageFlags2 WorkStages() const;
  void BeginTiming();
  // After a command.
  void WriteTimestamp(const std::string& name);
  // Of a submission that is done.
  void CollectTimes();
  void WorkBarrier();
  void Barrier(VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access);

  const Device& device_;
  VkCommandBuffer handle_ = VK_NULL_HANDLE;
  VkFence fence_ = VK_NULL_HANDLE;
  bool submitted_ = false;
  uint32_t barriers_ = 0;
  std::set<VkBuffer> read_, written_;
  // Of Device::kernel_times: one timestamp before the first command and one after each.
  VkQueryPool queries_ = VK_NULL_HANDLE;
  uint32_t query_capacity_ = 0;
  std::vector<std::string> timed_;  // names of the commands since Begin
};

}  // namespace tetrec
