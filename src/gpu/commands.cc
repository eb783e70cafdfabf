// Records dispatches and draws into a command buffer, submits it, waits for it.
#include "gpu/commands.h"

#include "core/error.h"
#include "core/process_memory.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

// A binding that a kernel uses, and the buffer for it.
struct Use {
  const KernelBinding* binding;
  const Buffer* buffer;
};

const KernelBinding* FindBinding(const Program& program, uint32_t number) {
  for (const KernelBinding& binding : program.bindings()) {
    if (binding.number == number) return &binding;
  }
  return nullptr;
}

std::vector<Use> MatchBuffers(const Program& program, const BoundBuffers& buffers) {
  std::vector<Use> uses;
  for (const KernelBinding& binding : program.bindings()) {
    if (binding.is_used) uses.push_back({&binding, nullptr});
  }
  for (const auto& [number, buffer] : buffers) {
    const KernelBinding* binding = FindBinding(program, number);
    TETREC_CHECK(binding != nullptr, fmt::format("kernel {} has no binding {} for buffer '{}'",
                                                 program.name(), number, buffer->name()));
    if (!binding->is_used) continue;
    Use& use = *std::find_if(uses.begin(), uses.end(),
                             [&](const Use& other) { return other.binding == binding; });
    TETREC_CHECK(
        use.buffer == nullptr && buffer->handle() != VK_NULL_HANDLE,
        fmt::format("kernel {}: the buffer '{}' for binding {} ({}) is empty or the second",
                    program.name(), buffer->name(), number, binding->name));
    TETREC_CHECK(binding->access != Access::kTexelRead || buffer->view() != VK_NULL_HANDLE,
                 fmt::format("kernel {}: binding {} ({}) needs a texel buffer; '{}' has no format",
                             program.name(), number, binding->name, buffer->name()));
    use.buffer = buffer;
  }
  for (const Use& use : uses) {
    TETREC_CHECK(use.buffer != nullptr,
                 fmt::format("kernel {}: no buffer for binding {} ({})", program.name(),
                             use.binding->number, use.binding->name));
  }
  return uses;
}

}  // namespace

CommandRecorder::CommandRecorder(const Device& device) : device_(device) {
  VkCommandBufferAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                       .commandPool = device.command_pool,
                                       .level = VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                       .commandBufferCount = 1};
  TETREC_VK(vkAllocateCommandBuffers(device.handle, &allocate, &handle_));
  VkFenceCreateInfo fence{.sType = VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
  TETREC_VK(vkCreateFence(device.handle, &fence, nullptr, &fence_));
}

CommandRecorder::~CommandRecorder() {
  if (submitted_) vkWaitForFences(device_.handle, 1, &fence_, VK_TRUE, UINT64_MAX);
  vkDestroyQueryPool(device_.handle, queries_, nullptr);
  vkDestroyFence(device_.handle, fence_, nullptr);
  vkFreeCommandBuffers(device_.handle, device_.command_pool, 1, &handle_);
}

void CommandRecorder::Begin() {
  Wait();
  VkCommandBufferBeginInfo begin{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO,
                                 .flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT};
  TETREC_VK(vkBeginCommandBuffer(handle_, &begin));
  read_.clear();
  written_.clear();
  barriers_ = 0;
  // Work of an earlier submission may still be running on the same buffers.
  WorkBarrier();
  barriers_ = 0;
  if (device_.kernel_times) BeginTiming();
}

// The pool grows to the size that the last recording would have needed.
void CommandRecorder::BeginTiming() {
  const uint32_t needed = uint32_t(timed_.size()) + 1;
  if (needed > query_capacity_) {
    vkDestroyQueryPool(device_.handle, queries_, nullptr);
    query_capacity_ = std::max(1024u, 2 * needed);
    const VkQueryPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                     .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                     .queryCount = query_capacity_};
    TETREC_VK(vkCreateQueryPool(device_.handle, &pool, nullptr, &queries_));
  }
  timed_.clear();
  vkCmdResetQueryPool(handle_, queries_, 0, query_capacity_);
  vkCmdWriteTimestamp2(handle_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_, 0);
}

void CommandRecorder::WriteTimestamp(const std::string& name) {
  if (!device_.kernel_times) return;
  timed_.push_back(name);
  if (timed_.size() < query_capacity_) {
    vkCmdWriteTimestamp2(handle_, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries_,
                         uint32_t(timed_.size()));
  }
}

// All commands before a timestamp are done when it is written, so differences do not overlap.
void CommandRecorder::CollectTimes() {
  const size_t count = std::min<size_t>(timed_.size() + 1, query_capacity_);
  std::vector<uint64_t> ticks(count);
  TETREC_VK(vkGetQueryPoolResults(device_.handle, queries_, 0, uint32_t(count), count * 8,
                                  ticks.data(), 8,
                                  VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT));
  const uint64_t mask = ~0ull >> (64 - device_.timestamp_bits);
  const double seconds_per_tick = 1e-9 * double(device_.properties.limits.timestampPeriod);
  for (size_t i = 1; i < count; ++i) {
    KernelTimes::Entry& entry = device_.kernel_times->by_name[timed_[i - 1]];
    ++entry.calls;
    entry.seconds += seconds_per_tick * double((ticks[i] - ticks[i - 1]) & mask);
  }
  device_.kernel_times->untimed_calls += timed_.size() + 1 - count;
}

VkPipelineStageFlags2 CommandRecorder::WorkStages() const {
  const VkPipelineStageFlags2 compute =
      VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_2_TRANSFER_BIT;
  if (!device_.has_raster) return compute;
  return compute | VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;
}

void CommandRecorder::WorkBarrier() {
  Barrier(WorkStages() | VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT,
          VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT | VK_ACCESS_2_SHADER_READ_BIT |
              VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_TRANSFER_READ_BIT |
              VK_ACCESS_2_TRANSFER_WRITE_BIT);
}

void CommandRecorder::Barrier(VkPipelineStageFlags2 to_stage, VkAccessFlags2 to_access) {
  const VkMemoryBarrier2 barrier{
      .sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
      .srcStageMask = WorkStages(),
      .srcAccessMask = VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT,
      .dstStageMask = to_stage,
      .dstAccessMask = to_access};
  const VkDependencyInfo dependency{.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                    .memoryBarrierCount = 1,
                                    .pMemoryBarriers = &barrier};
  vkCmdPipelineBarrier2(handle_, &dependency);
  read_.clear();
  written_.clear();
  ++barriers_;
}

void CommandRecorder::Bind(const Program& program, const BoundBuffers& buffers, const void* push,
                           uint32_t push_bytes) {
  TETREC_CHECK(push_bytes == program.push_bytes(),
               fmt::format("kernel {} has {} bytes of push constants, not {}", program.name(),
                           program.push_bytes(), push_bytes));
  const std::vector<Use> uses = MatchBuffers(program, buffers);
  const bool races = std::any_of(uses.begin(), uses.end(), [&](const Use& use) {
    const VkBuffer buffer = use.buffer->handle();
    return written_.contains(buffer) || (Writes(use.binding->access) && read_.contains(buffer));
  });
  if (races) WorkBarrier();
  has_new_kernels_ = has_new_kernels_ || !program.is_compiled();

  std::vector<VkDescriptorBufferInfo> infos(uses.size());
  std::vector<VkBufferView> views(uses.size());
  std::vector<VkWriteDescriptorSet> writes(uses.size());
  for (size_t i = 0; i < uses.size(); ++i) {
    const auto& [binding, buffer] = uses[i];
    const bool is_texel = binding->access == Access::kTexelRead;
    infos[i] = {.buffer = buffer->handle(), .offset = 0, .range = VK_WHOLE_SIZE};
    views[i] = buffer->view();
    writes[i] = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                 .dstBinding = binding->number,
                 .descriptorCount = 1,
                 .descriptorType = is_texel ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER
                                            : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                 .pBufferInfo = is_texel ? nullptr : &infos[i],
                 .pTexelBufferView = is_texel ? &views[i] : nullptr};
    (Writes(binding->access) ? written_ : read_).insert(buffer->handle());
  }
  const VkPipelineBindPoint bind_point = program.stages() == VK_SHADER_STAGE_COMPUTE_BIT
                                             ? VK_PIPELINE_BIND_POINT_COMPUTE
                                             : VK_PIPELINE_BIND_POINT_GRAPHICS;
  vkCmdBindPipeline(handle_, bind_point, program.pipeline());
  device_.push_descriptor_set(handle_, bind_point, program.layout(), 0, uint32_t(writes.size()),
                              writes.data());
  if (push_bytes > 0) {
    vkCmdPushConstants(handle_, program.layout(), program.stages(), 0, push_bytes, push);
  }
}

void CommandRecorder::DispatchBytes(const Program& program, const BoundBuffers& buffers,
                                    const void* push, uint32_t push_bytes, uint64_t threads,
                                    bool in_rows) {
  TETREC_CHECK(program.stages() == VK_SHADER_STAGE_COMPUTE_BIT, program.name());
  const uint32_t* limits = device_.properties.limits.maxComputeWorkGroupCount;
  const uint64_t groups = (threads + program.local_size() - 1) / program.local_size();
  if (groups == 0) return;
  const uint64_t rows = in_rows ? (groups + limits[0] - 1) / limits[0] : 1;
  const uint64_t columns = (groups + rows - 1) / rows;
  TETREC_CHECK(columns <= limits[0] && rows <= limits[1],
               fmt::format("dispatch of {}: {} workgroups", program.name(), groups));
  Bind(program, buffers, push, push_bytes);
  vkCmdDispatch(handle_, uint32_t(columns), uint32_t(rows), 1);
  WriteTimestamp(program.name());
}

void CommandRecorder::DispatchCountedBytes(const Program& program, const BoundBuffers& buffers,
                                           const void* push, uint32_t push_bytes,
                                           const Buffer& groups) {
  TETREC_CHECK(program.stages() == VK_SHADER_STAGE_COMPUTE_BIT, program.name());
  if (written_.contains(groups.handle())) WorkBarrier();
  Bind(program, buffers, push, push_bytes);
  read_.insert(groups.handle());
  vkCmdDispatchIndirect(handle_, groups.handle(), 0);
  WriteTimestamp(program.name());
}

void CommandRecorder::DrawBytes(const Program& program, const BoundBuffers& buffers,
                                const void* push, uint32_t push_bytes, uint32_t vertices,
                                const PixelRect& viewport, const PixelRect& area) {
  TETREC_CHECK(program.stages() != VK_SHADER_STAGE_COMPUTE_BIT, program.name());
  if (vertices == 0 || area.width == 0 || area.height == 0) return;
  Bind(program, buffers, push, push_bytes);
  const VkViewport clip{.x = float(viewport.x),
                        .y = float(viewport.y),
                        .width = float(viewport.width),
                        .height = float(viewport.height),
                        .minDepth = 0.0f,
                        .maxDepth = 1.0f};
  const VkRect2D rect{{int32_t(area.x), int32_t(area.y)}, {area.width, area.height}};
  vkCmdSetViewport(handle_, 0, 1, &clip);
  vkCmdSetScissor(handle_, 0, 1, &rect);
  const VkRenderingInfo rendering{
      .sType = VK_STRUCTURE_TYPE_RENDERING_INFO, .renderArea = rect, .layerCount = 1};
  vkCmdBeginRendering(handle_, &rendering);
  vkCmdDraw(handle_, vertices, 1, 0, 0);
  vkCmdEndRendering(handle_);
  WriteTimestamp(program.name());
}

void CommandRecorder::FillZero(const Buffer& buffer) {
  if (written_.contains(buffer.handle()) || read_.contains(buffer.handle())) WorkBarrier();
  vkCmdFillBuffer(handle_, buffer.handle(), 0, VK_WHOLE_SIZE, 0);
  WriteTimestamp("fill");
  written_.insert(buffer.handle());
}

void CommandRecorder::EndAndSubmit() {
  Barrier(VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT | VK_ACCESS_2_HOST_WRITE_BIT);
  TETREC_VK(vkEndCommandBuffer(handle_));
  const VkCommandBufferSubmitInfo command{.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO,
                                          .commandBuffer = handle_};
  const VkSubmitInfo2 submit{.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2,
                             .commandBufferInfoCount = 1,
                             .pCommandBufferInfos = &command};
  TETREC_VK(vkQueueSubmit2(device_.queue, 1, &submit, fence_));
  submitted_ = true;
}

void CommandRecorder::Wait() {
  if (!submitted_) return;
  submitted_ = false;  // nobody waits again for a device that is lost
  TETREC_VK(vkWaitForFences(device_.handle, 1, &fence_, VK_TRUE, UINT64_MAX));
  TETREC_VK(vkResetFences(device_.handle, 1, &fence_));
  if (device_.kernel_times) CollectTimes();
  // A driver that runs kernels on the CPU compiles some of them only when they first run, and
  // leaves tens of megabytes of freed blocks.
  if (has_new_kernels_) ReturnFreedMemory();
  has_new_kernels_ = false;
}

}  // namespace tetrec
