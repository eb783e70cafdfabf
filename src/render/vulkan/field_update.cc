// The kernels that change a field on the device.
#include "render/vulkan/field_update.h"

#include "embedded_shaders.h"
#include "render/adam_push.h"
#include "render/vulkan/integrator.h"

namespace tetrec {

using gpu_types::AdamPush;
using gpu_types::SpreadPush;

namespace {

// For programs whose kernels include shaders/storage.glsl and shaders/density.glsl.
std::vector<SpecializationConstant> UpdateConstantsOf(const FieldLayout& layout) {
  std::vector<SpecializationConstant> constants = ConstantsOf(layout);
  constants.push_back({kConstantDensityActivation, int32_t(layout.density().activation)});
  return constants;
}

Program AdamProgram(const Device& device, const FieldLayout& layout, bool fixed_point) {
  static_assert(kColorOffset == kColorComponent && kDensityOffset == kDensityComponent);
  const std::span<const uint32_t> fixed = kAdamFixed, floats = kAdam;
  return Program(device, "adam", fixed_point ? fixed : floats, UpdateConstantsOf(layout));
}

// For the attributes behind colour and density; none if there are none.
Program AdamOthersProgram(const Device& device, const FieldLayout& layout, bool fixed_point) {
  static_assert(kMostAttributes == kMostOtherAttributes + 2 && kMostComponents < 256);
  if (layout.IsStandard()) return {};
  std::vector<SpecializationConstant> constants;
  for (size_t i = 2; i < layout.attributes.size(); ++i) {
    const Attribute& attribute = layout.attributes[i];
    constants.push_back({kConstantAttributes + uint32_t(constants.size()),
                         attribute.components | int32_t(attribute.activation) << 8 |
                             int32_t(attribute.rate) << 16});
  }
  const std::span<const uint32_t> fixed = kAdamOthersFixed, floats = kAdamOthers;
  return Program(device, "adam_others", fixed_point ? fixed : floats, constants);
}

AdamPush PushOf(const AdamUpdate& update, const DeviceField& field, const FixedPoint& fixed) {
  AdamPush push = MakeAdamPush(update, field.layout.density(), field.row_count);
  push.quanta[kRateColor] = 1.0f / fixed.color_quanta;
  push.quanta[kRateHarmonics] = 1.0f / fixed.color_quanta;
  push.quanta[kRateDensity] = 1.0f / fixed.density_quanta;
  return push;
}

}  // namespace

FieldUpdate::FieldUpdate(const Device& device, const FieldLayout& layout, bool fixed_point)
    : adam_(AdamProgram(device, layout, fixed_point)),
      adam_others_(AdamOthersProgram(device, layout, fixed_point)),
      spread_(Program(device, "spread", kSpread, UpdateConstantsOf(layout))) {}

void FieldUpdate::Adam(CommandRecorder& recorder, DeviceField& field, const AdamUpdate& update,
                       const FixedPoint& fixed) const {
  AdamPush push = PushOf(update, field, fixed);
  push.first_cell = field.first_cell;
  recorder.DispatchMany(adam_,
                        {{kBindVertexGradients, field.gradients},
                         {kBindParameters, field.parameters},
                         {kBindMoments, field.moments},
                         {kBindGradientTexels, field.gradients},
                         {kBindParameterTexels, field.parameters},
                         {kBindMomentTexels, field.moments},
                         {kBindRowRateTexels, field.row_rates},
                         {kBindVertices, field.vertices}},
                        push, field.row_count);
}

void FieldUpdate::Others(CommandRecorder& recorder, DeviceField& field, const AdamUpdate& update,
                         const FixedPoint& fixed) const {
  if (!field.others || !field.others.HasSums()) return;
  AdamPush push = PushOf(WithoutMomentum(update), field, fixed);
  push.stride = field.others.stride;
  push.moment_stride = field.others.attributes;
  recorder.DispatchMany(adam_others_,
                        {{kBindOtherGradients, field.others.gradients},
                         {kBindHasGradients, field.others.has_gradients},
                         {kBindParameters, field.others.parameters},
                         {kBindMoments, field.others.moments},
                         {kBindRowRates, field.row_rates}},
                        push, field.row_count);
}

void FieldUpdate::Spread(CommandRecorder& recorder, DeviceField& field) const {
  recorder.DispatchMany(
      spread_, {{kBindParameters, field.parameters}, {kBindVertices, field.vertices}},
      SpreadPush{field.row_count, field.first_cell, field.layout.density().scale}, field.row_count);
}

}  // namespace tetrec
