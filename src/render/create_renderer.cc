// The one place that knows all renderers.
#include "render/create_renderer.h"

#include "core/error.h"
#include "render/reference/reference_renderer.h"

#ifdef TETREC_WITH_VULKAN
#include "render/vulkan/vulkan_renderer.h"
#endif

#include <fmt/format.h>

namespace tetrec {

std::unique_ptr<TrainingRenderer> CreateRenderer(const RendererOptions& options) {
  return CreateProbedRenderer(options);
}

std::unique_ptr<ProbedRenderer> CreateProbedRenderer(const RendererOptions& options) {
  if (options.kind == RendererKind::kReference) return CreateReferenceRenderer(options);
#ifdef TETREC_WITH_VULKAN
  return CreateVulkanRenderer(options);
#else
  throw EnvironmentError(fmt::format(
      "the renderer '{}' needs Vulkan, which this build was made without", Name(options.kind)));
#endif
}

}  // namespace tetrec
