// What differs between the Vulkan renderers: how rays get their colours from a field, and how the
// field's vertices get their gradients from the rays.
#pragma once

#include "gpu/commands.h"
#include "render/device_field.h"
#include "render/ray_batch.h"
#include "shared/gpu_types.glsl.h"

namespace tetrec {

// One pass over a batch.
struct RayPass {
  DeviceField& field;
  RayBatch& rays;
  const Buffer& views;     // GpuView; the batch's blocks name them
  const Buffer& counters;  // of kCounterCount
  gpu_types::MarchPush push;
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  // Before the first pass over a new mesh; the device is idle.
  virtual void SetMesh(const DeviceField&) {}
  // Records what fills rays.colors. May submit what was recorded so far, wait, and begin again.
  virtual void Forward(CommandRecorder& recorder, const RayPass& pass) = 0;
  // Records what adds to field.gradients, after Forward of the same batch.
  virtual void Backward(CommandRecorder& recorder, const RayPass& pass) = 0;
};

}  // namespace tetrec
