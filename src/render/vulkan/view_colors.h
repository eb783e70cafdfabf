// View-dependent colour on the device: what every row of a field shows to each view of a batch, and
// the gradients of that (shaders/view_colors.comp).
#pragma once

#include "gpu/commands.h"
#include "render/training_renderer.h"
#include "render/vulkan/fixed_point.h"
#include "render/vulkan/integrator.h"

namespace tetrec {

class ViewColors {
 public:
  // For fields of this layout; does nothing if their colours do not depend on the view.
  ViewColors(const Device& device, const FieldLayout& layout, bool fixed_point);

  // True if a batch of so many views needs more room. The device must be idle then for MakeRoom.
  bool NeedsRoom(const DeviceField& field, size_t views) const;
  void MakeRoom(const DeviceField& field, size_t views);
  // Forgets the rooms of the field before.
  void Clear() { colors_ = {}, gradients_ = {}, seen_rows_ = {}; }

  // Gives a pass the colours of its views, which Record evaluates.
  void Bind(RayPass& pass) const;
  void Record(CommandRecorder& recorder, const RayPass& pass) const;
  // Records what turns gradients of these colours into gradients of the field, whose other sums
  // must be there (AllocateOtherGradients).
  void RecordBackward(CommandRecorder& recorder, const RayPass& pass) const;
  // The same for colour and density, and the step of the coefficients, which needs no sums of them.
  void RecordStep(CommandRecorder& recorder, const RayPass& pass, const AdamUpdate& update,
                  const FixedPoint& fixed) const;

 private:
  gpu_types::ViewColorPush PushOf(const RayPass& pass) const;
  // Records what lists the rows that have gradients.
  void RecordSeenRows(CommandRecorder& recorder, const RayPass& pass) const;
  BoundBuffers SumBuffers(const RayPass& pass) const;

  const Device* device_;
  bool is_on_, fixed_point_;
  Program forward_, backward_, seen_, step_;
  Buffer colors_, gradients_;  // rows [slot][row]: texels vec4; sums by colour and density
  Buffer seen_rows_;           // their number, then the rows
};

}  // namespace tetrec
