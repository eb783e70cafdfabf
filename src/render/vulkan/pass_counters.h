// What the kernels of all passes count.
#pragma once

#include "gpu/buffer.h"
#include "render/renderer.h"
#include "shared/gpu_types.glsl.h"

namespace tetrec {

class PassCounters {
 public:
  explicit PassCounters(const Device& device) : buffer_(device, "counters", kCounterCount * 4) {
    buffer_.FillZero();
  }

  const Buffer& buffer() const { return buffer_; }  // of kCounterCount
  void AddRays(uint64_t rays) { counts_.rays += rays; }
  // Moves the counts off the device, whose 32 bits would overflow in images of many steps. The
  // device must be idle.
  void Collect() {
    AddTo(counts_);
    buffer_.FillZero();
  }
  // The device must be idle.
  RenderCounts Counts() const {
    RenderCounts counts = counts_;
    AddTo(counts);
    return counts;
  }

 private:
  void AddTo(RenderCounts& counts) const {
    const auto counters = buffer_.DownloadAs<uint32_t>(kCounterCount);
    counts.lost_rays += counters[kCounterLostRays];
    counts.clamped_addends += counters[kCounterClamped];
    counts.hit_rays += counters[kCounterHitRays];
    counts.steps += counters[kCounterSteps];
  }

  Buffer buffer_;
  RenderCounts counts_;  // without those still in buffer_
};

}  // namespace tetrec
