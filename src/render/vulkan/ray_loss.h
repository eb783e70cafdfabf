// The loss of a batch on the device, and what becomes of it on the host.
#pragma once

#include "render/vulkan/dssim_loss.h"
#include "render/vulkan/exposure_gather.h"

#include <memory>

namespace tetrec {

// A training batch on the device.
struct BatchSlot {
  RayBatch rays;
  DssimBatch dssim;
  uint32_t uncollected_rays = 0;  // whose losses are yet to be read
};

// What the loss leaves in RayBatch::gradients.
struct RayGradients {
  float scale = 1;             // of the loss
  bool are_residuals = false;  // by what is shown, for scores
};

class RayLoss {
 public:
  explicit RayLoss(const Device& device);

  // Records the commands that compare the batch's colours with the targets, and those that sum what
  // exposures are fitted from if the batch asks for it. `views`: the training views.
  void Record(CommandRecorder& recorder, BatchSlot& slot, const TrainingBatch& batch,
              const RayGradients& gradients, const Buffer& views, const Buffer& targets,
              const ExposureGather& exposures);
  // Sums the losses of a batch that the device is done with.
  static StepResult Collect(BatchSlot& slot);

 private:
  // What only a loss with a D-SSIM part needs.
  struct WithDssim {
    explicit WithDssim(const Device& device);
    Program program;
    DssimLoss dssim;
  };

  const Device& device_;
  Program program_;
  std::unique_ptr<WithDssim> with_dssim_;  // once a batch needs it
};

}  // namespace tetrec
