// The march written by hand for AVX2, eight rays at a time: how fast a CPU can do what
// march_forward.comp does.
#pragma once

#include "render/renderer.h"

#include <glm/glm.hpp>

#include <memory>
#include <span>
#include <vector>

namespace tetrec {

class HandMarch {
 public:
  explicit HandMarch(const RadianceField& field);
  ~HandMarch();
  // As TrainingRenderer::MarchBlocks with the exact integral, for cameras outside the mesh whose
  // pictures are whole blocks; on all cores.
  std::vector<glm::vec4> MarchBlocks(const RenderView& view, std::span<const RayBlock> blocks,
                                     float stop_transmittance) const;
  // Whether this CPU has AVX2 and FMA.
  static bool CanRun();

 private:
  struct Mesh;
  std::unique_ptr<const Mesh> mesh_;
};

}  // namespace tetrec
