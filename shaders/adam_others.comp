// One step of Adam (shared/adam.glsl.h) on the attributes behind colour and density.
//
// Rows of parameters and gradients have push.stride values, in the order of the layout
// (field/layout.h); rows of moments have all first moments, then all second ones. A row without
// gradients stays as it is, moments included, unlike those of colour and density: most rows of a
// step have none, and to read and write all of them would cost as much as the rays.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef TETREC_FIXED_POINT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#define Sum int64_t
#else
#define Sum float
#endif
#include "shared/adam.glsl.h"
#include "shared/gpu_types.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(std430, binding = kBindOtherGradients) buffer OtherGradients { Sum other_gradients[]; };
layout(std430, binding = kBindHasGradients) buffer HasGradients { uint has_gradients[]; };
layout(std430, binding = kBindParameters) buffer Parameters { float parameters[]; };
layout(std430, binding = kBindMoments) buffer Moments { float moments[]; };
layout(std430, binding = kBindRateShares) readonly buffer RateShares { float rate_shares[]; };
layout(push_constant) uniform Push { AdamPush push; };

// Each attribute is components | activation << 8 | rate class << 16; 0 means that there is none.
layout(constant_id = kConstantAttributes) const int kAttribute2 = 0;
layout(constant_id = kConstantAttributes + 1) const int kAttribute3 = 0;
layout(constant_id = kConstantAttributes + 2) const int kAttribute4 = 0;
layout(constant_id = kConstantAttributes + 3) const int kAttribute5 = 0;
layout(constant_id = kConstantAttributes + 4) const int kAttribute6 = 0;
layout(constant_id = kConstantAttributes + 5) const int kAttribute7 = 0;

void Update(uint row, uint component, int activation, int rate_class) {
  uint at = row * push.stride + component, moment = row * push.stride + at;
  float parameter = parameters[at];
  float gradient = push.quanta[rate_class] * float(other_gradients[at]);
  other_gradients[at] = Sum(0);
  if (activation == kActivationExp) gradient *= exp(parameter);
  AdamState state =
      AdamStep(AdamState(parameter, moments[moment], moments[moment + push.stride]),
               AdamRates(push.beta1, push.beta2, push.epsilon, push.second_moment_correction),
               rate_shares[row] * push.rates[rate_class], gradient);
  moments[moment] = state.first;
  moments[moment + push.stride] = state.second;
  parameters[at] = ClampParameter(activation, state.parameter, push.least_log, push.largest_log);
}

// Returns the first component behind the attribute.
uint UpdateAttribute(uint row, uint first, int kind) {
  uint component = first, end = first + uint(kind & 255);
  while (component < end) {
    Update(row, component, kind >> 8 & 255, kind >> 16);
    component += 1u;
  }
  return end;
}

void main() {
  uint row = ThreadIndex();
  if (row < push.row_count && has_gradients[row] != 0u) {
    has_gradients[row] = 0u;
    uint next = UpdateAttribute(row, 0u, kAttribute2);
    if (kAttribute3 != 0) next = UpdateAttribute(row, next, kAttribute3);
    if (kAttribute4 != 0) next = UpdateAttribute(row, next, kAttribute4);
    if (kAttribute5 != 0) next = UpdateAttribute(row, next, kAttribute5);
    if (kAttribute6 != 0) next = UpdateAttribute(row, next, kAttribute6);
    if (kAttribute7 != 0) next = UpdateAttribute(row, next, kAttribute7);
  }
}
