// View-dependent colour on the device.
#include "render/vulkan/view_colors.h"

#include "embedded_shaders.h"
#include "render/adam_push.h"

namespace tetrec {
namespace {

uint64_t ColorBytes(const DeviceField& field, size_t views) {
  return uint64_t{field.row_count} * views * sizeof(glm::vec4);
}

Program BackwardProgram(const Device& device, const FieldLayout& layout, bool fixed_point) {
  const std::span<const uint32_t> fixed = kViewColorsBackwardFixed, floats = kViewColorsBackward;
  return Program(device, "view_colors_backward", fixed_point ? fixed : floats, ConstantsOf(layout));
}

Program SeenProgram(const Device& device, bool fixed_point) {
  const std::span<const uint32_t> fixed = kViewColorsSeenFixed, floats = kViewColorsSeen;
  return Program(device, "view_colors_seen", fixed_point ? fixed : floats);
}

Program StepProgram(const Device& device, const FieldLayout& layout, bool fixed_point) {
  const std::span<const uint32_t> fixed = kViewColorsStepFixed, floats = kViewColorsStep;
  return Program(device, "view_colors_step", fixed_point ? fixed : floats, ConstantsOf(layout));
}

}  // namespace

ViewColors::ViewColors(const Device& device, const FieldLayout& layout, bool fixed_point)
    : device_(&device), is_on_(layout.HarmonicsDegree() > 0), fixed_point_(fixed_point) {
  if (!is_on_) return;
  forward_ = Program(device, "view_colors", kViewColors, ConstantsOf(layout));
  backward_ = BackwardProgram(device, layout, fixed_point);
  seen_ = SeenProgram(device, fixed_point);
  step_ = StepProgram(device, layout, fixed_point);
}

bool ViewColors::NeedsRoom(const DeviceField& field, size_t views) const {
  return is_on_ && colors_.bytes() < ColorBytes(field, views);
}

void ViewColors::MakeRoom(const DeviceField& field, size_t views) {
  if (!NeedsRoom(field, views)) return;
  Clear();  // frees the old rooms before the new ones take memory
  colors_ =
      Buffer(*device_, "view colors", ColorBytes(field, views), VK_FORMAT_R32G32B32A32_SFLOAT);
  gradients_ =
      Buffer(*device_, "gradients by views",
             uint64_t{field.row_count} * views * kStandardComponents * (fixed_point_ ? 8 : 4),
             VK_FORMAT_R32G32B32A32_SFLOAT);
  gradients_.FillZero();
  seen_rows_ = Buffer(*device_, "seen rows",
                      (uint64_t{field.row_count} + kSeenRowsHeader) * sizeof(uint32_t));
}

void ViewColors::Bind(RayPass& pass) const {
  if (!is_on_) return;
  pass.colors = &colors_;
  pass.gradients = &gradients_;
}

gpu_types::ViewColorPush ViewColors::PushOf(const RayPass& pass) const {
  return {.row_count = pass.field.row_count,
          .first_cell = pass.field.first_cell,
          .slots = pass.rays.slots,
          .other_stride = pass.field.others.stride};
}

void ViewColors::Record(CommandRecorder& recorder, const RayPass& pass) const {
  if (!is_on_) return;
  recorder.DispatchMany(forward_,
                        {{kBindVertices, pass.field.vertices},
                         {kBindTets, pass.field.tets},
                         {kBindCenters, pass.rays.centers},
                         {kBindHarmonics, pass.field.others.parameters},
                         {kBindViewColors, colors_}},
                        PushOf(pass), pass.field.row_count);
}

// The buffers of the kernels that include shaders/view_color_sums.glsl.
BoundBuffers ViewColors::SumBuffers(const RayPass& pass) const {
  return {{kBindVertices, pass.field.vertices},
          {kBindTets, pass.field.tets},
          {kBindCenters, pass.rays.centers},
          {kBindSlotGradients, gradients_},
          {kBindSlotGradientTexels, gradients_},
          {kBindVertexGradients, pass.field.gradients},
          {kBindSeenRows, seen_rows_}};
}

void ViewColors::RecordSeenRows(CommandRecorder& recorder, const RayPass& pass) const {
  recorder.FillZero(seen_rows_);
  recorder.DispatchMany(seen_,
                        {{kBindSlotGradients, gradients_},
                         {kBindSlotGradientTexels, gradients_},
                         {kBindSeenRows, seen_rows_}},
                        gpu_types::SeenRowsPush{pass.field.row_count, pass.rays.slots},
                        pass.field.row_count);
}

void ViewColors::RecordBackward(CommandRecorder& recorder, const RayPass& pass) const {
  if (!is_on_) return;
  RecordSeenRows(recorder, pass);
  const OtherAttributes& others = pass.field.others;
  BoundBuffers buffers = SumBuffers(pass);
  buffers.emplace_back(kBindOtherGradients, others.gradients);
  buffers.emplace_back(kBindOtherGradientTexels, others.gradients);
  buffers.emplace_back(kBindHasGradients, others.has_gradients);
  recorder.DispatchCounted(backward_, buffers, PushOf(pass), seen_rows_);
}

void ViewColors::RecordStep(CommandRecorder& recorder, const RayPass& pass,
                            const AdamUpdate& update, const FixedPoint& fixed) const {
  if (!is_on_) return;
  const OtherAttributes& others = pass.field.others;
  RecordSeenRows(recorder, pass);
  const gpu_types::ViewColorStepPush push{.row_count = pass.field.row_count,
                                          .first_cell = pass.field.first_cell,
                                          .slots = pass.rays.slots,
                                          .other_stride = others.stride,
                                          .moment_stride = others.attributes,
                                          .rate = float(update.harmonics_rate),
                                          .beta2 = update.beta2,
                                          .epsilon = update.epsilon,
                                          .quantum = 1.0f / fixed.color_quanta,
                                          .decay = HarmonicsDecayOfStep(update)};
  BoundBuffers buffers = SumBuffers(pass);
  buffers.emplace_back(kBindHarmonics, others.parameters);
  buffers.emplace_back(kBindParameters, others.parameters);
  buffers.emplace_back(kBindMoments, others.moments);
  buffers.emplace_back(kBindRowRates, pass.field.row_rates);
  recorder.DispatchCounted(step_, buffers, push, seen_rows_);
}

}  // namespace tetrec
