// One step on the attributes behind colour and density, by the sums of their gradients.
//
// Rows of parameters and gradients have push.stride values, in the order of the layout
// (field/layout.h); rows of moments have one second moment per attribute (shared/adam.glsl.h). Steps
// of training change coefficients of view-dependent colour without these sums (view_colors_step.comp).
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef TETREC_FIXED_POINT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#define Sum int64_t
#else
#define Sum float
#endif
#define TETREC_NEVER (push.row_count == 0u)
#include "shared/adam.glsl.h"
#include "shared/gpu_types.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(std430, binding = kBindOtherGradients) buffer OtherGradients { Sum other_gradients[]; };
layout(std430, binding = kBindHasGradients) buffer HasGradients { uint has_gradients[]; };
layout(std430, binding = kBindParameters) buffer Parameters { float parameters[]; };
layout(std430, binding = kBindMoments) buffer Moments { float moments[]; };
layout(std430, binding = kBindRowRates) readonly buffer RowRates { vec4 row_rates[]; };
layout(push_constant) uniform Push { AdamPush push; };

// Each attribute is components | activation << 8 | rate class << 16; 0 means that there is none.
layout(constant_id = kConstantAttributes) const int kAttribute2 = 0;
layout(constant_id = kConstantAttributes + 1) const int kAttribute3 = 0;
layout(constant_id = kConstantAttributes + 2) const int kAttribute4 = 0;
layout(constant_id = kConstantAttributes + 3) const int kAttribute5 = 0;
layout(constant_id = kConstantAttributes + 4) const int kAttribute6 = 0;
layout(constant_id = kConstantAttributes + 5) const int kAttribute7 = 0;

// dL/dparameter of a component whose gradient is at `at`.
float GradientAt(uint at, int activation, int rate_class) {
  float gradient = push.quanta[rate_class] * float(other_gradients[at]);
  if (activation == kActivationExp) gradient *= exp(parameters[at]);
  return gradient;
}

// Updates the attribute `number` of a row, `kind`, whose components begin at `begin`; clears its
// gradients. Returns where they end.
uint UpdateAttribute(int kind, uint row, uint number, uint begin) {
  int activation = kind >> 8 & 255, rate_class = kind >> 16;
  uint end = begin + uint(kind & 255);
  precise float squares = 0.0;
  uint at = begin;
  while (at < end) {
    float gradient = GradientAt(at, activation, rate_class);
    squares += gradient * gradient;
    at += 1u;
  }
  float rate = 0.0;
  float decay = rate_class == kRateHarmonics ? row_rates[row].x * push.harmonics_decay : 0.0;
  TETREC_RARELY(squares > 0.0) {
    uint moment = row * push.moment_stride + number;
    float second = SharedMoment(moments[moment], squares / float(kind & 255), push.beta2);
    moments[moment] = second;
    rate = SharedRate(row_rates[row].x * push.rates[rate_class], second, push.epsilon);
  }
  at = begin;
  while (at < end) {
    precise float next = SharedStep(parameters[at], decay, rate, GradientAt(at, activation, rate_class));
    if (squares > 0.0) parameters[at] = ClampParameter(activation, next, push.least_log, push.largest_log);
    other_gradients[at] = Sum(0);
    at += 1u;
  }
  return end;
}

void main() {
  uint row = ThreadIndex();
  TETREC_RARELY(row < push.row_count && has_gradients[row] != 0u) {
    has_gradients[row] = 0u;
    uint at = row * push.stride;
    if (kAttribute2 != 0) at = UpdateAttribute(kAttribute2, row, 0u, at);
    if (kAttribute3 != 0) at = UpdateAttribute(kAttribute3, row, 1u, at);
    if (kAttribute4 != 0) at = UpdateAttribute(kAttribute4, row, 2u, at);
    if (kAttribute5 != 0) at = UpdateAttribute(kAttribute5, row, 3u, at);
    if (kAttribute6 != 0) at = UpdateAttribute(kAttribute6, row, 4u, at);
    if (kAttribute7 != 0) at = UpdateAttribute(kAttribute7, row, 5u, at);
  }
}
