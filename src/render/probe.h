// What tests and benchmarks ask of a renderer beyond what training needs.
#pragma once

#include "render/training_renderer.h"

#include <glm/glm.hpp>

#include <span>
#include <string>
#include <vector>

namespace tetrec {

// dL/d(colour, density) of every row of the field, and GradientSums::position and
// absolute_position if asked for.
struct FieldGradient {
  std::vector<glm::vec3> color_srgb;
  std::vector<float> density;
  std::vector<glm::vec3> position;
  std::vector<float> absolute_position;
};

class RendererProbe {
 public:
  virtual ~RendererProbe() = default;
  // dL/dfield for dL/d(rgb, transmittance) of each pixel of a view rendered with one ray per pixel.
  virtual FieldGradient Backpropagate(const RenderView& view,
                                      std::span<const glm::vec4> pixel_gradient,
                                      GradientParts parts = GradientParts::kColorDensity) = 0;
  // Colour before the background and optical depth of every ray of `blocks`, all of `view` (their
  // `view` is 0), one ray per pixel; zero outside the picture.
  virtual std::vector<glm::vec4> MarchBlocks(const RenderView& view,
                                             std::span<const RayBlock> blocks) = 0;
  // Messages of the Vulkan validation layer since the renderer was made; empty if there are none,
  // or the layer is off.
  virtual std::vector<std::string> ValidationMessages() const = 0;
};

// What the renderers are: of training, and open to a probe.
class ProbedRenderer : public TrainingRenderer, public RendererProbe {};

}  // namespace tetrec
