// Renderers on Vulkan.
#pragma once

#include "render/probe.h"

namespace tetrec {

// Every kind but kReference. Throws EnvironmentError where there is no such device.
std::unique_ptr<ProbedRenderer> CreateVulkanRenderer(const RendererOptions& options);

}  // namespace tetrec
