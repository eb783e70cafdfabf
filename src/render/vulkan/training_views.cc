// The training views on the device, and the pictures that they should show.
#include "render/vulkan/training_views.h"

#include "core/error.h"
#include "mesh/locate.h"
#include "render/vulkan/gpu_view.h"

#include <fmt/format.h>

namespace tetrec {

void TrainingViews::SetTargets(std::span<const RenderView> views,
                               std::span<const TargetImage> targets) {
  TETREC_CHECK(views.size() == targets.size(), "one target per view");
  views_.assign(views.begin(), views.end());
  first_pixels_.clear();
  uint64_t pixels = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    TETREC_CHECK(
        views[i].camera.width == targets[i].width && views[i].camera.height == targets[i].height,
        fmt::format("target {} and its camera differ in size", i));
    first_pixels_.push_back(uint32_t(pixels));
    pixels += targets[i].rgba8.size();
  }
  constexpr uint64_t kPixelsOfTexel = 4;
  const uint64_t bytes =
      (pixels + kPixelsOfTexel - 1) / kPixelsOfTexel * kPixelsOfTexel * sizeof(uint32_t);
  if (targets_.bytes() != bytes) {
    targets_ = {};  // frees the old ones before the new ones take memory
    targets_ = Buffer(device_, "target pictures", bytes, VK_FORMAT_R32G32B32A32_UINT);
  }
  for (size_t i = 0; i < targets.size(); ++i) {
    const std::vector<uint32_t>& rgba8 = targets[i].rgba8;
    if (rgba8.empty()) continue;
    targets_.Upload(rgba8.data(), rgba8.size() * sizeof(uint32_t),
                    first_pixels_[i] * sizeof(uint32_t));
  }
}

void TrainingViews::EnterField(const DeviceField& field) {
  for (RayViews& rays : ray_views_) rays.views.clear();
  uint32_t tet = 0;
  for (size_t i = 0; i < views_.size(); ++i) {
    tet = FindTet(field.mesh, views_[i].cam_from_world.Inverse().translation,
                  tet == kNoTet ? 0 : tet, field.not_convex.empty());
    for (int samples = 1; samples <= kMostTrainingSamples; ++samples) {
      ray_views_[size_t(samples - 1)].views.push_back(
          MakeGpuView(views_[i], samples, first_pixels_[i], tet));
    }
  }
  for (RayViews& rays : ray_views_) {
    rays.buffer = MakeBuffer(device_, "views", rays.views, VK_FORMAT_R32G32B32A32_UINT);
  }
}

const RayViews& TrainingViews::ViewsFor(const TrainingBatch& batch) const {
  TETREC_CHECK(batch.samples >= 1 && batch.samples <= kMostTrainingSamples,
               "1 or 2 x 2 rays per pixel");
  if (batch.dssim_weight > 0) {
    TETREC_CHECK(batch.samples == 1, "D-SSIM takes one ray per pixel");
    for (const RayBlock& block : batch.blocks) {
      const Camera& camera = views_[block.view].camera;
      TETREC_CHECK(int(block.x) + kRayBlockWidth <= camera.width &&
                       int(block.y) + kRayBlockHeight <= camera.height,
                   "a tile of D-SSIM leaves its picture");
    }
  }
  return ray_views_[size_t(batch.samples - 1)];
}

}  // namespace tetrec
