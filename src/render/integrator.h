// What differs between the Vulkan renderers: how rays get their colours from a field, and how the
// field's vertices get their gradients from the rays.
#pragma once

#include "gpu/commands.h"
#include "render/device_field.h"
#include "render/ray_batch.h"
#include "shared/gpu_types.glsl.h"
#include "shared/integral.glsl.h"

#include <array>
#include <span>

namespace tetrec {

// One pass over a batch.
struct RayPass {
  DeviceField& field;
  RayBatch& rays;
  const Buffer& views;               // GpuView; the batch's blocks name them
  std::span<const RayBlock> blocks;  // the host's copies of the batch's blocks
  const gpu_types::GpuView& view;    // and of the first one's view
  const Buffer& counters;            // of kCounterCount
  gpu_types::MarchPush push;
  GradientParts parts = GradientParts::kColorDensity;  // of Backward
  bool count_steps = false;                            // of Forward: hit rays and steps, too
};

inline SpecializationConstant ConstantOf(FieldStorage storage) {
  return {kConstantStorage, storage == FieldStorage::kCell ? kStorageCell : kStorageVertex};
}

// For programs whose kernels include shaders/integral.glsl and shaders/storage.glsl.
inline std::array<SpecializationConstant, 3> ConstantsOf(const IntegralOptions& integral,
                                                         FieldStorage storage) {
  return {{{kConstantIntegral, int(integral.kind)},
           {kConstantSplits, integral.splits},
           ConstantOf(storage)}};
}

// A kernel that sums (shaders/atomic_sum.glsl), in its three kinds.
struct SummingKernel {
  std::span<const uint32_t> native, compare_and_swap, fixed_point;

  std::span<const uint32_t> For(const Device& device, bool is_fixed_point) const {
    if (is_fixed_point) return fixed_point;
    return device.has_float_atomics ? native : compare_and_swap;
  }
};

class Integrator {
 public:
  virtual ~Integrator() = default;
  // What SetField and the passes over pictures will take for a mesh, at most.
  virtual uint64_t BytesFor(const TetMesh&) const { return 0; }
  // Throws DataError where the integrator cannot render the mesh.
  virtual void CheckMesh(const TetMesh&) const {}
  // A new mesh is on the device, which is idle. The field stays where it is until the next call.
  virtual void SetField(const DeviceField&) {}
  // Records what fills rays.colors. May submit what was recorded so far, wait, and begin again.
  virtual void Forward(CommandRecorder& recorder, const RayPass& pass) = 0;
  // Records what adds to field.gradients, and field.position_gradients where pass.parts has them;
  // after Forward of the same batch.
  virtual void Backward(CommandRecorder& recorder, const RayPass& pass) = 0;
};

}  // namespace tetrec
