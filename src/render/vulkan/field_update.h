// The kernels that change a field on the device: Adam, and the spread of parameters to what the
// renderers read.
#pragma once

#include "gpu/commands.h"
#include "render/training_renderer.h"
#include "render/vulkan/device_field.h"

namespace tetrec {

class FieldUpdate {
 public:
  // The kernels know where rows of this layout keep their attributes.
  FieldUpdate(const Device& device, const FieldLayout& layout, bool fixed_point);

  // Records one step of Adam on colour and density, which uses and clears the sums of their
  // gradients. `fixed`: of the sums.
  void Adam(CommandRecorder& recorder, DeviceField& field, const AdamUpdate& update,
            const FixedPoint& fixed) const;
  // The same for the attributes behind them; nothing if they have no sums.
  void Others(CommandRecorder& recorder, DeviceField& field, const AdamUpdate& update,
              const FixedPoint& fixed) const;
  // Records what gives the renderers the field of the parameters.
  void Spread(CommandRecorder& recorder, DeviceField& field) const;

 private:
  Program adam_, adam_others_, spread_;
};

}  // namespace tetrec
