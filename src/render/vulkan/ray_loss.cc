// The loss of a batch on the device, and what becomes of it on the host.
#include "render/vulkan/ray_loss.h"

#include "embedded_shaders.h"
#include "shared/loss.glsl.h"

#include <utility>

namespace tetrec {

using gpu_types::LossPush;

static_assert(int(LossKind::kL2) == kLossL2 && int(LossKind::kL1) == kLossL1 &&
              int(LossKind::kSignedL2) == kLossSignedL2);

RayLoss::RayLoss(const Device& device) : device_(device), program_(device, "loss", kLoss) {}

RayLoss::WithDssim::WithDssim(const Device& device)
    : program(device, "loss (pictures)", kLossWithPictures), dssim(device) {}

void RayLoss::Record(CommandRecorder& recorder, BatchSlot& slot, const TrainingBatch& batch,
                     const RayGradients& gradients, const Buffer& views, const Buffer& targets,
                     const ExposureGather& exposures) {
  const bool with_dssim = batch.dssim_weight > 0;
  if (with_dssim && !with_dssim_) with_dssim_ = std::make_unique<WithDssim>(device_);
  RayBatch& rays = slot.rays;
  const LossPush push{.ray_count = rays.count,
                      .loss = uint32_t(batch.loss),
                      .gradient_scale = gradients.scale * (1.0f - batch.dssim_weight),
                      .writes_residuals = gradients.are_residuals,
                      .background = glm::vec4(batch.background_srgb, 0.0f),
                      .samples = uint32_t(batch.samples),
                      .alpha_weight = batch.alpha_weight};
  slot.uncollected_rays = rays.count;
  if (batch.sums_exposures) exposures.Record(recorder, rays, batch.blocks, push, views, targets);
  slot.dssim.weight = batch.dssim_weight;
  BoundBuffers buffers = {{kBindViews, views},
                          {kBindBlocks, rays.blocks},
                          {kBindRayColors, rays.colors},
                          {kBindRayGradients, rays.gradients},
                          {kBindPartialLosses, rays.partial_losses},
                          {kBindTargets, targets},
                          {kBindExposures, exposures.exposures()}};
  if (!with_dssim) {
    recorder.Dispatch(program_, buffers, push, rays.count);
    return;
  }
  with_dssim_->dssim.Prepare(slot.dssim, batch);
  buffers.emplace_back(kBindPictures, slot.dssim.pictures);
  recorder.Dispatch(with_dssim_->program, buffers, push, rays.count);
  with_dssim_->dssim.Record(recorder, slot.dssim, rays, batch, exposures.exposures());
}

StepResult RayLoss::Collect(BatchSlot& slot) {
  const uint32_t rays = std::exchange(slot.uncollected_rays, 0);
  StepResult result;
  if (rays == 0) return result;
  const uint32_t groups = (rays + kWorkgroupSize - 1) / kWorkgroupSize;
  for (const glm::vec2& partial : slot.rays.partial_losses.DownloadAs<glm::vec2>(groups)) {
    result.loss += partial.x;
    result.squared_error += partial.y;
  }
  result.loss = slot.dssim.Mix(result.loss / (3.0 * rays));
  result.squared_error /= 3.0 * rays;
  return result;
}

}  // namespace tetrec
