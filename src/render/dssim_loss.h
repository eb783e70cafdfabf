// The loss of a batch of tiles with a D-SSIM part, on the device.
#pragma once

#include "gpu/commands.h"
#include "render/ray_batch.h"
#include "shared/gpu_types.glsl.h"

#include <cstdint>

namespace tetrec {

// What the loss of a batch in flight needs; grows with it.
struct DssimBatch {
  Buffer pictures, window_rows, window_terms, partial_ssims;
  double weight = 0;  // of D-SSIM; 0: the batch has none
  uint64_t windows = 0, workgroups = 0;

  // The batch's loss from the mean of its pixel loss. The device must be done with it.
  double Mix(double pixel_loss) const;
};

class DssimLoss {
 public:
  explicit DssimLoss(const Device& device);

  // Records what fills rays.gradients and rays.partial_losses. `pixel_loss`: as for the pixel loss
  // alone. The device must be done with `batch`.
  void Record(CommandRecorder& recorder, DssimBatch& batch, const RayBatch& rays,
              const TrainingStep& step, gpu_types::LossPush pixel_loss, const Buffer& views,
              const Buffer& targets) const;

 private:
  const Device& device_;
  Program loss_, rows_, windows_, spread_, gradients_;
};

// SSIM's windows in a batch, channel by channel.
uint64_t CountWindows(const TrainingStep& step);

// The largest gradient to expect of a ray, for fixed-point sums.
double GradientScale(const TrainingStep& step);

}  // namespace tetrec
