// A kernel: pipeline, layout of its bindings, size of its push constants.
#include "gpu/program.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace tetrec {

VkShaderModule MakeShaderModule(VkDevice device, std::span<const uint32_t> spirv) {
  VkShaderModuleCreateInfo info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                .codeSize = spirv.size_bytes(),
                                .pCode = spirv.data()};
  VkShaderModule shader = VK_NULL_HANDLE;
  TETREC_VK(vkCreateShaderModule(device, &info, nullptr, &shader));
  return shader;
}

namespace {

void CheckKernel(const std::string& name, const Reflection& kernel,
                 std::span<const SpecializationConstant> constants) {
  for (const SpecializationConstant& constant : constants) {
    TETREC_CHECK(
        std::binary_search(kernel.constant_ids.begin(), kernel.constant_ids.end(), constant.id),
        fmt::format("kernel {} has no specialization constant {}", name, constant.id));
  }
  // Threads are numbered along x. lavapipe fills its 8 lanes along x only.
  const auto& size = kernel.local_size;
  TETREC_CHECK(size[0] > 0 && size[0] % 8 == 0 && size[1] == 1 && size[2] == 1,
               fmt::format("kernel {} has a local size of {} x {} x {}; expected 8 n x 1 x 1", name,
                           size[0], size[1], size[2]));
}

VkResult MakeComputePipeline(VkDevice device, std::span<const uint32_t> spirv,
                             std::span<const SpecializationConstant> constants,
                             VkPipelineLayout layout, VkPipeline* pipeline) {
  const VkShaderModule shader = MakeShaderModule(device, spirv);
  std::vector<VkSpecializationMapEntry> entries;
  for (size_t i = 0; i < constants.size(); ++i) {
    entries.push_back({.constantID = constants[i].id,
                       .offset = uint32_t(i * sizeof(SpecializationConstant) +
                                          offsetof(SpecializationConstant, value)),
                       .size = sizeof(int32_t)});
  }
  const VkSpecializationInfo specialization{.mapEntryCount = uint32_t(entries.size()),
                                            .pMapEntries = entries.data(),
                                            .dataSize = constants.size_bytes(),
                                            .pData = constants.data()};
  VkComputePipelineCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
      .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                .module = shader,
                .pName = "main",
                .pSpecializationInfo = &specialization},
      .layout = layout};
  const VkResult result =
      vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, pipeline);
  vkDestroyShaderModule(device, shader, nullptr);
  return result;
}

}  // namespace

Program::Program(const Device& device, std::string name, Reflection reflection,
                 VkShaderStageFlags stages, MakePipeline make_pipeline)
    : device_(&device),
      name_(std::move(name)),
      reflection_(std::move(reflection)),
      stages_(stages),
      make_pipeline_(std::move(make_pipeline)) {
  TETREC_CHECK(push_bytes() <= device.properties.limits.maxPushConstantsSize,
               fmt::format("kernel {} has {} bytes of push constants; the device takes {}", name_,
                           push_bytes(), device.properties.limits.maxPushConstantsSize));
  std::vector<VkDescriptorSetLayoutBinding> slots;
  for (const KernelBinding& binding : bindings()) {
    if (!binding.is_used) continue;
    slots.push_back({.binding = binding.number,
                     .descriptorType = binding.access == Access::kTexelRead
                                           ? VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER
                                           : VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                     .descriptorCount = 1,
                     .stageFlags = stages_,
                     .pImmutableSamplers = nullptr});
  }
  VkDescriptorSetLayoutCreateInfo set{
      .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
      .flags = VK_DESCRIPTOR_SET_LAYOUT_CREATE_PUSH_DESCRIPTOR_BIT_KHR,
      .bindingCount = uint32_t(slots.size()),
      .pBindings = slots.data()};
  TETREC_VK(vkCreateDescriptorSetLayout(device.handle, &set, nullptr, &set_layout_));
  const VkPushConstantRange range{stages_, 0, push_bytes()};
  VkPipelineLayoutCreateInfo layout{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                    .setLayoutCount = 1,
                                    .pSetLayouts = &set_layout_,
                                    .pushConstantRangeCount = push_bytes() > 0 ? 1u : 0u,
                                    .pPushConstantRanges = &range};
  TETREC_VK(vkCreatePipelineLayout(device.handle, &layout, nullptr, &layout_));
}

Program::Program(const Device& device, std::string name, std::span<const uint32_t> spirv,
                 std::span<const SpecializationConstant> constants)
    : Program(
          device, name, Reflect(name, spirv), VK_SHADER_STAGE_COMPUTE_BIT,
          [handle = device.handle, spirv, values = std::vector(constants.begin(), constants.end())](
              VkPipelineLayout layout, VkPipeline* pipeline) {
            return MakeComputePipeline(handle, spirv, values, layout, pipeline);
          }) {
  CheckKernel(name_, reflection_, constants);
}

VkPipeline Program::pipeline() const {
  if (pipeline_ == VK_NULL_HANDLE) CheckVulkan(make_pipeline_(layout_, &pipeline_), name_.c_str());
  return pipeline_;
}

Program::~Program() {
  if (device_ == nullptr) return;
  vkDestroyPipeline(device_->handle, pipeline_, nullptr);
  vkDestroyPipelineLayout(device_->handle, layout_, nullptr);
  vkDestroyDescriptorSetLayout(device_->handle, set_layout_, nullptr);
}

void Program::Swap(Program& other) noexcept {
  std::swap(device_, other.device_);
  std::swap(name_, other.name_);
  std::swap(reflection_, other.reflection_);
  std::swap(stages_, other.stages_);
  std::swap(set_layout_, other.set_layout_);
  std::swap(layout_, other.layout_);
  std::swap(make_pipeline_, other.make_pipeline_);
  std::swap(pipeline_, other.pipeline_);
}

}  // namespace tetrec
