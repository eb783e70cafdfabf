// Renderers on Vulkan.
#pragma once

#include "render/renderer.h"

namespace tetrec {

// Every kind but kReference. Throws EnvironmentError where there is no such device.
std::unique_ptr<TrainingRenderer> CreateVulkanRenderer(const RendererOptions& options);

}  // namespace tetrec
