// The march written by hand for AVX2, eight rays at a time: the speed that a CPU can reach at the
// work of march_forward.comp.
#pragma once

#include "render/training_renderer.h"

#include <glm/glm.hpp>

#include <memory>
#include <span>
#include <vector>

namespace tetrec {

class HandMarch {
 public:
  explicit HandMarch(const RadianceField& field);
  ~HandMarch();
  // Does what RendererProbe::MarchBlocks does with the exact integral, on all cores, for cameras
  // outside the mesh whose images consist of whole blocks.
  std::vector<glm::vec4> MarchBlocks(const RenderView& view, std::span<const RayBlock> blocks,
                                     float stop_transmittance) const;
  // True if this CPU has AVX2 and FMA.
  static bool CanRun();

 private:
  struct Mesh;
  std::unique_ptr<const Mesh> mesh_;
};

}  // namespace tetrec
