// The training views on the device, and the pictures that they should show.
#pragma once

#include "gpu/buffer.h"
#include "render/training_renderer.h"
#include "render/vulkan/device_field.h"
#include "shared/gpu_types.glsl.h"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Views as grids of rays, with one number of rays per pixel.
struct RayViews {
  std::vector<gpu_types::GpuView> views;
  Buffer buffer;  // the same
};

class TrainingViews {
 public:
  explicit TrainingViews(const Device& device) : device_(device) {}

  // One picture per view, of its size. The device must be done with those before.
  void SetTargets(std::span<const RenderView> views, std::span<const TargetImage> targets);
  // Finds the tets of `field` in which the cameras stand: rays start there. To be called for other
  // views, another field, or moved vertices; the device must be idle.
  void EnterField(const DeviceField& field);

  size_t size() const { return views_.size(); }
  // With one ray per pixel, where the cameras are.
  std::span<const gpu_types::GpuView> of_pixels() const { return ray_views_[0].views; }
  const Buffer& targets() const { return targets_; }
  // For as many rays per pixel as the batch has. TETREC_CHECKs that there are such views, and that
  // tiles of D-SSIM, whose windows must not reach where rays have no target, are in their pictures.
  const RayViews& ViewsFor(const TrainingBatch& batch) const;

 private:
  const Device& device_;
  std::vector<RenderView> views_;
  std::vector<uint32_t> first_pixels_;                    // of each view's target
  Buffer targets_;                                        // pixels
  std::array<RayViews, kMostTrainingSamples> ray_views_;  // by TrainingBatch::samples, from 1 on
};

}  // namespace tetrec
