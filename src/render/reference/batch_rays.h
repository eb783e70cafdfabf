// The rays of a batch: blocks of neighbouring rays of several views.
#pragma once

#include "render/ray_blocks.h"
#include "render/reference/batch.h"
#include "shared/random.glsl.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>

namespace tetrec {

struct BatchRays {
  std::span<const RenderView> views;
  std::span<const RayBlock> blocks;
  float jitter_px = 0;
  uint32_t seed = 0;
  int samples = 1;  // per pixel along each side

  size_t count() const { return blocks.size() * kRaysPerBlock; }
  uint32_t IndexOfView(size_t ray) const { return blocks[ray / kRaysPerBlock].view; }
  const RenderView& ViewOf(size_t ray) const { return views[IndexOfView(ray)]; }
  glm::ivec2 PixelAt(size_t ray) const { return PixelOfRay(blocks, ray) / samples; }
  bool InPicture(size_t ray) const {
    const glm::ivec2 at = PixelAt(ray);
    return at.x < ViewOf(ray).camera.width && at.y < ViewOf(ray).camera.height;
  }
  bool IsFirstOfPixel(size_t ray) const {
    const glm::ivec2 at = PixelOfRay(blocks, ray);
    return at.x % samples == 0 && at.y % samples == 0;
  }
};

inline BatchRays RaysOf(std::span<const RenderView> views, const TrainingBatch& batch) {
  return {views, batch.blocks, batch.jitter_px, batch.seed, batch.samples};
}

// The same ray as in rays.glsl.
template <class Real>
WorldRay<Real> RayOf(const BatchRays& batch, size_t i) {
  const uint32_t random = gpu_types::Hash(batch.seed ^ gpu_types::Hash(uint32_t(i)));
  const glm::dvec2 unit(gpu_types::UnitFloat(random),
                        gpu_types::UnitFloat(gpu_types::Hash(random)));
  const glm::dvec2 inside = 0.5 + double(batch.jitter_px) * (unit - 0.5);
  const glm::dvec2 in_grid = glm::dvec2(PixelOfRay(batch.blocks, i)) + inside;
  return RayThrough<Real>(batch.ViewOf(i), in_grid / double(batch.samples));
}

}  // namespace tetrec
