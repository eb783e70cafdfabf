// A kernel: pipeline, layout of its bindings, size of its push constants.
#pragma once

#include "gpu/device.h"
#include "gpu/reflection.h"

#include <functional>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

// A value for `layout(constant_id = id) const int`; the driver compiles the kernel for it.
struct SpecializationConstant {
  uint32_t id;
  int32_t value;
};

// What the kernel binds and how large its push constants and workgroups are comes from its SPIR-V,
// which must stay where it is: the driver compiles it when the pipeline is asked for the first
// time, because a run needs few of the kernels that a renderer has.
class Program {
 public:
  Program() = default;
  // A compute kernel; raster_program.h makes the other kind. Throws BugError if the kernel lacks
  // one of the constants or has a local size that lavapipe runs badly.
  Program(const Device& device, std::string name, std::span<const uint32_t> spirv,
          std::span<const SpecializationConstant> constants = {});
  Program(Program&& other) noexcept { Swap(other); }
  Program& operator=(Program&& other) noexcept {
    Swap(other);
    return *this;
  }
  ~Program();

  // Throws EnvironmentError if the driver cannot compile the kernel.
  VkPipeline pipeline() const;
  bool is_compiled() const { return pipeline_ != VK_NULL_HANDLE; }
  VkPipelineLayout layout() const { return layout_; }
  VkShaderStageFlags stages() const { return stages_; }
  const std::vector<KernelBinding>& bindings() const { return reflection_.bindings; }
  uint32_t push_bytes() const { return reflection_.push_bytes; }
  uint32_t local_size() const { return reflection_.local_size[0]; }
  const std::string& name() const { return name_; }

 private:
  using MakePipeline = std::function<VkResult(VkPipelineLayout layout, VkPipeline* pipeline)>;

  Program(const Device& device, std::string name, Reflection reflection, VkShaderStageFlags stages,
          MakePipeline make_pipeline);
  friend Program MakeRasterProgram(const Device& device, std::string name,
                                   std::span<const uint32_t> vertex_spirv,
                                   std::span<const uint32_t> fragment_spirv);
  void Swap(Program& other) noexcept;

  const Device* device_ = nullptr;
  std::string name_;
  Reflection reflection_;
  VkShaderStageFlags stages_ = 0;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  MakePipeline make_pipeline_;
  mutable VkPipeline pipeline_ = VK_NULL_HANDLE;  // once it has been asked for
};

// The caller destroys it.
VkShaderModule MakeShaderModule(VkDevice device, std::span<const uint32_t> spirv);

}  // namespace tetrec
