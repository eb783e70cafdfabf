// What all renderers share.
#include "render/renderer.h"

#include "render/reference_renderer.h"
#include "render/vulkan_renderer.h"

#include <algorithm>
#include <cmath>

namespace tetrec {

std::vector<glm::vec4> ParametersOf(const RadianceField& field) {
  constexpr float kLeastDensity = 1.8e-35f;  // e^-80, above float's denormals
  std::vector<glm::vec4> parameters(field.density.size());
  for (size_t v = 0; v < parameters.size(); ++v) {
    parameters[v] =
        glm::vec4(field.color_srgb[v], std::log(std::max(field.density[v], kLeastDensity)));
  }
  return parameters;
}

std::unique_ptr<TrainingRenderer> CreateRenderer(const RendererOptions& options) {
  if (options.kind == RendererKind::kReference) return CreateReferenceRenderer(options);
  return CreateVulkanRenderer(options);
}

}  // namespace tetrec
