// The D-SSIM part of the loss of a batch of tiles, on the device.
#pragma once

#include "gpu/commands.h"
#include "render/vulkan/ray_batch.h"
#include "shared/gpu_types.glsl.h"

#include <cstdint>

namespace tetrec {

// Buffers for the loss of a batch in flight; they grow with it.
struct DssimBatch {
  Buffer pictures, window_rows, window_terms, partial_ssims;
  double weight = 0;  // of D-SSIM; 0 if the batch has none
  uint64_t windows = 0, workgroups = 0;

  // The batch's loss, given the mean of its pixel loss. The device must be done with the batch.
  double Mix(double pixel_loss) const;
};

class DssimLoss {
 public:
  explicit DssimLoss(const Device& device);

  // Makes room for the batch, and for batch.pictures, which the pixel loss fills
  // (shaders/loss.comp). The device must be done with `batch`.
  void Prepare(DssimBatch& batch, const TrainingBatch& step) const;
  // Records the commands that follow the pixel loss: they add to rays.gradients.
  void Record(CommandRecorder& recorder, const DssimBatch& batch, const RayBatch& rays,
              const TrainingBatch& step, const Buffer& exposures) const;

 private:
  const Device& device_;
  Program rows_, windows_, spread_, gradients_;
};

// The number of SSIM windows in a batch, counted for each channel.
uint64_t CountWindows(const TrainingBatch& step);

// The largest gradient to expect from a ray, for fixed-point sums.
double GradientScale(const TrainingBatch& step);

}  // namespace tetrec
