// What differs between the Vulkan renderers: how rays get their colours from a field, and how the
// field gets its gradients from the rays.
#pragma once

#include "gpu/commands.h"
#include "render/vulkan/device_field.h"
#include "render/vulkan/ray_batch.h"
#include "shared/gpu_types.glsl.h"
#include "shared/integral.glsl.h"

#include <span>
#include <vector>

namespace tetrec {

// One pass over a batch.
struct RayPass {
  DeviceField& field;
  RayBatch& rays;
  const Buffer& views;               // of GpuView, to which the batch's blocks refer
  std::span<const RayBlock> blocks;  // the host's copy of the batch's blocks
  const gpu_types::GpuView& view;    // and of the first block's view
  const Buffer& counters;            // of kCounterCount
  gpu_types::RayPush push;
  // Where kernels find colours and add gradients of colour and density (view_colors.h); those of
  // the field itself if colours do not depend on the view.
  const Buffer* colors = &field.vertices;
  const Buffer* gradients = &field.gradients;
  GradientParts parts = GradientParts::kColorDensity;  // for Backward
  bool count_steps = false;                            // for Forward: also count hit rays and steps
  ScoreKind score = ScoreKind::kSquaredResidual;       // for scores
};

// A pass over blocks that are in `rays`; `view` is that of the first block.
RayPass MakePass(DeviceField& field, RayBatch& rays, const Buffer& views,
                 std::span<const RayBlock> blocks, const gpu_types::GpuView& view,
                 const Buffer& counters, float stop_transmittance, const FixedPoint& fixed);

// The mesh, the views and the blocks of a pass, which every kernel that makes rays reads, and
// `more`.
inline BoundBuffers MeshAnd(const RayPass& pass, const BoundBuffers& more) {
  BoundBuffers all = {{kBindTets, pass.field.tets},
                      {kBindVertices, pass.field.vertices},
                      {kBindColors, *pass.colors},
                      {kBindViews, pass.views},
                      {kBindBlocks, pass.rays.blocks}};
  all.insert(all.end(), more.begin(), more.end());
  return all;
}

// For programs whose kernels include shaders/storage.glsl.
inline std::vector<SpecializationConstant> ConstantsOf(const FieldLayout& layout) {
  const bool has_cells = layout.storage == FieldStorage::kCell;
  return {{kConstantStorage, has_cells ? kStorageCell : kStorageVertex},
          {kConstantHarmonics, HarmonicsCount(layout.HarmonicsDegree())}};
}

// For programs whose kernels include shaders/integral.glsl.
inline std::vector<SpecializationConstant> ConstantsOf(const IntegralOptions& integral) {
  return {{kConstantIntegral, int(integral.kind)}, {kConstantSplits, integral.splits}};
}

// For programs whose kernels include both.
inline std::vector<SpecializationConstant> ConstantsOf(const IntegralOptions& integral,
                                                       const FieldLayout& layout) {
  std::vector<SpecializationConstant> constants = ConstantsOf(integral);
  const std::vector<SpecializationConstant> more = ConstantsOf(layout);
  constants.insert(constants.end(), more.begin(), more.end());
  return constants;
}

// The three kinds of a kernel that sums (shaders/atomic_sum.glsl).
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
  // An upper bound on the memory that SetField and passes over images will take for a mesh.
  virtual uint64_t BytesFor(const TetMesh&) const { return 0; }
  // Throws DataError if the integrator cannot render the mesh.
  virtual void CheckMesh(const TetMesh&) const {}
  // Announces a new mesh on the device, which is idle. The field stays in place until the next
  // call.
  virtual void SetField(const DeviceField&) {}
  // The vertices of that field have moved; the device is idle.
  virtual void FollowVertices(const DeviceField& field) { SetField(field); }
  // Records the commands that fill rays.colors. May submit what was recorded so far, wait, and
  // begin again.
  virtual void Forward(CommandRecorder& recorder, const RayPass& pass) = 0;
  // Records the commands that add to *pass.gradients, and to field.position_gradients if pass.parts
  // includes them; follows Forward of the same batch.
  virtual void Backward(CommandRecorder& recorder, const RayPass& pass) = 0;
};

}  // namespace tetrec
