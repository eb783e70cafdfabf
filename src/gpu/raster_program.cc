// A graphics pipeline without attachments.
#include "gpu/raster_program.h"

#include "core/error.h"

#include <fmt/format.h>

namespace tetrec {

namespace {

VkResult MakeRasterPipeline(VkDevice device, std::span<const uint32_t> vertex_spirv,
                            std::span<const uint32_t> fragment_spirv, VkPipelineLayout layout,
                            VkPipeline* pipeline) {
  const VkShaderModule vertex = MakeShaderModule(device, vertex_spirv);
  const VkShaderModule fragment = MakeShaderModule(device, fragment_spirv);
  const VkPipelineShaderStageCreateInfo stages[] = {
      {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
       .stage = VK_SHADER_STAGE_VERTEX_BIT,
       .module = vertex,
       .pName = "main"},
      {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
       .stage = VK_SHADER_STAGE_FRAGMENT_BIT,
       .module = fragment,
       .pName = "main"}};
  const VkPipelineVertexInputStateCreateInfo no_input{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
  const VkPipelineInputAssemblyStateCreateInfo triangles{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
      .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
  const VkPipelineViewportStateCreateInfo viewport{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
      .viewportCount = 1,
      .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo both_sides{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
      .polygonMode = VK_POLYGON_MODE_FILL,
      .cullMode = VK_CULL_MODE_NONE,
      .frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
      .lineWidth = 1.0f};
  const VkPipelineMultisampleStateCreateInfo one_sample{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
      .rasterizationSamples = VK_SAMPLE_COUNT_1_BIT};
  const VkDynamicState dynamic_states[] = {VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
  const VkPipelineDynamicStateCreateInfo dynamic{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
      .dynamicStateCount = 2,
      .pDynamicStates = dynamic_states};
  const VkPipelineRenderingCreateInfo no_attachments{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO};
  const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .pNext = &no_attachments,
                                          .stageCount = 2,
                                          .pStages = stages,
                                          .pVertexInputState = &no_input,
                                          .pInputAssemblyState = &triangles,
                                          .pViewportState = &viewport,
                                          .pRasterizationState = &both_sides,
                                          .pMultisampleState = &one_sample,
                                          .pDynamicState = &dynamic,
                                          .layout = layout};
  const VkResult result =
      vkCreateGraphicsPipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, pipeline);
  vkDestroyShaderModule(device, vertex, nullptr);
  vkDestroyShaderModule(device, fragment, nullptr);
  return result;
}

}  // namespace

Program MakeRasterProgram(const Device& device, std::string name,
                          std::span<const uint32_t> vertex_spirv,
                          std::span<const uint32_t> fragment_spirv) {
  if (!device.has_raster) {
    throw EnvironmentError(
        fmt::format("Vulkan device '{}' cannot rasterise into buffers (no graphics queue, dynamic "
                    "rendering or fragmentStoresAndAtomics): choose another device or the renderer "
                    "'march'",
                    device.properties.deviceName));
  }
  Reflection both = Merge(name, Reflect(name, vertex_spirv), Reflect(name, fragment_spirv));
  return {device, std::move(name), std::move(both),
          VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT,
          [handle = device.handle, vertex_spirv, fragment_spirv](VkPipelineLayout layout,
                                                                 VkPipeline* pipeline) {
            return MakeRasterPipeline(handle, vertex_spirv, fragment_spirv, layout, pipeline);
          }};
}

}  // namespace tetrec
