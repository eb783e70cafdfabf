// A kernel: pipeline, layout of its bindings, size of its push constants.
#pragma once

#include "gpu/device.h"

#include <span>
#include <string>
#include <vector>

namespace tetrec {

// How a kernel uses a binding; the command recorder derives barriers from it.
enum class Access { kTexelRead, kRead, kWrite, kReadWrite };

struct BindingSpec {
  uint32_t binding;
  Access access;
};

// A value for `layout(constant_id = id) const int`; the driver compiles the kernel for it.
struct SpecializationConstant {
  uint32_t id;
  int32_t value;
};

class Program {
 public:
  Program() = default;
  // A compute kernel; raster_program.h makes the other kind.
  Program(const Device& device, std::string name, std::span<const uint32_t> spirv,
          std::vector<BindingSpec> bindings, uint32_t push_bytes,
          std::span<const SpecializationConstant> constants = {});
  Program(Program&& other) noexcept { Swap(other); }
  Program& operator=(Program&& other) noexcept {
    Swap(other);
    return *this;
  }
  ~Program();

  VkPipeline pipeline() const { return pipeline_; }
  VkPipelineLayout layout() const { return layout_; }
  VkShaderStageFlags stages() const { return stages_; }
  const std::vector<BindingSpec>& bindings() const { return bindings_; }
  uint32_t push_bytes() const { return push_bytes_; }
  const std::string& name() const { return name_; }

 private:
  // Without a pipeline.
  Program(const Device& device, std::string name, std::vector<BindingSpec> bindings,
          uint32_t push_bytes, VkShaderStageFlags stages);
  friend Program MakeRasterProgram(const Device& device, std::string name,
                                   std::span<const uint32_t> vertex_spirv,
                                   std::span<const uint32_t> fragment_spirv,
                                   std::vector<BindingSpec> bindings, uint32_t push_bytes);
  void Swap(Program& other) noexcept;

  const Device* device_ = nullptr;
  std::string name_;
  std::vector<BindingSpec> bindings_;
  uint32_t push_bytes_ = 0;
  VkShaderStageFlags stages_ = 0;
  VkDescriptorSetLayout set_layout_ = VK_NULL_HANDLE;
  VkPipelineLayout layout_ = VK_NULL_HANDLE;
  VkPipeline pipeline_ = VK_NULL_HANDLE;
};

// The caller destroys it.
VkShaderModule MakeShaderModule(const Device& device, std::span<const uint32_t> spirv);

}  // namespace tetrec
