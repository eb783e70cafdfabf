// Exposures of the training views on the device, and the sums that they are fitted from.
#pragma once

#include "gpu/commands.h"
#include "render/vulkan/ray_batch.h"
#include "shared/gpu_types.glsl.h"

#include <span>
#include <vector>

namespace tetrec {

class ExposureGather {
 public:
  explicit ExposureGather(const Device& device);

  // One per training view. The device must be done with those before.
  void SetExposures(std::span<const ViewExposure> exposures);
  size_t views() const { return views_; }
  const Buffer& exposures() const { return exposures_; }

  // Records the sums of a batch's blocks. `push` is that of the loss. The device must be done with
  // the batch before in these buffers.
  void Record(CommandRecorder& recorder, RayBatch& rays, std::span<const RayBlock> blocks,
              const gpu_types::LossPush& push, const Buffer& views, const Buffer& targets) const;
  // Keeps the sums of a batch that the device is done with.
  void Collect(RayBatch& rays);
  // Adds the sums that were kept, one per view, and forgets them.
  void TakeSums(std::span<ExposureSums> sums);
  void ForgetSums() { block_sums_.clear(); }

 private:
  const Device& device_;
  Program program_;
  Buffer exposures_;
  size_t views_ = 0;
  std::vector<BlockExposureSums> block_sums_;
};

}  // namespace tetrec
