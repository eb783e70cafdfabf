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
#define TETREC_NEVER (push.row_count == 0u)
#include "shared/adam.glsl.h"
#include "shared/gpu_types.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(std430, binding = kBindOtherGradients) buffer OtherGradients { Sum other_gradients[]; };
layout(std430, binding = kBindHasGradients) buffer HasGradients { uint has_gradients[]; };
layout(std430, binding = kBindParameters) buffer Parameters { float parameters[]; };
layout(std430, binding = kBindMoments) buffer Moments { float moments[]; };
layout(std430, binding = kBindRateShares) readonly buffer RateShares { float rate_shares[]; };
// The same rows as texels, which are read whole.
layout(binding = kBindGradientTexels) uniform textureBuffer gradient_texels;
layout(binding = kBindParameterTexels) uniform textureBuffer parameter_texels;
layout(binding = kBindMomentTexels) uniform textureBuffer moment_texels;
layout(push_constant) uniform Push { AdamPush push; };

// Each attribute is components | activation << 8 | rate class << 16; 0 means that there is none.
layout(constant_id = kConstantAttributes) const int kAttribute2 = 0;
layout(constant_id = kConstantAttributes + 1) const int kAttribute3 = 0;
layout(constant_id = kConstantAttributes + 2) const int kAttribute4 = 0;
layout(constant_id = kConstantAttributes + 3) const int kAttribute5 = 0;
layout(constant_id = kConstantAttributes + 4) const int kAttribute6 = 0;
layout(constant_id = kConstantAttributes + 5) const int kAttribute7 = 0;

// The kind of a component by the attribute that contains it; 0 behind the last one, where rows are
// padded.
int KindOf(uint component) {
  int kinds[kMostOtherAttributes] =
      int[](kAttribute2, kAttribute3, kAttribute4, kAttribute5, kAttribute6, kAttribute7);
  uint end = 0u;
  int kind = 0;
#define Look(i)                                              \
  if (component >= end) {                                    \
    end += uint(kinds[i] & 255);                             \
    kind = component < end ? kinds[i] : 0;                   \
  }
  Look(0) Look(1) Look(2) Look(3) Look(4) Look(5)
  return kind;
}

// dL/dvalue of a texel of a row, in quanta; clears it.
vec4 TakeGradients(uint texel) {
  uint at = 4u * texel;
#ifdef TETREC_FIXED_POINT
  vec4 gradient = vec4(other_gradients[at], other_gradients[at + 1u], other_gradients[at + 2u],
                       other_gradients[at + 3u]);
#else
  vec4 gradient = texelFetch(gradient_texels, int(texel));
#endif
  if (gradient != vec4(0.0)) {
    other_gradients[at] = Sum(0);
    other_gradients[at + 1u] = Sum(0);
    other_gradients[at + 2u] = Sum(0);
    other_gradients[at + 3u] = Sum(0);
  }
  return gradient;
}

AdamState Next(AdamState before, float gradient, uint row, uint component) {
  int kind = KindOf(component), activation = kind >> 8 & 255, rate_class = kind >> 16;
  gradient *= push.quanta[rate_class];
  if (activation == kActivationExp) gradient *= exp(before.parameter);
  AdamState next = AdamStep(
      before, AdamRates(push.beta1, push.beta2, push.epsilon, push.second_moment_correction),
      rate_shares[row] * push.rates[rate_class], gradient);
  next.parameter = ClampParameter(activation, next.parameter, push.least_log, push.largest_log);
  return next;
}

void Put(uint at, uint first_moment, AdamState next) {
  parameters[at] = next.parameter;
  moments[first_moment] = next.first;
  moments[first_moment + push.stride] = next.second;
}

// Updates the four components of one texel of a row.
void UpdateTexel(uint row, uint texel) {
  uint texels = push.stride / 4u, at = row * texels + texel, moment = row * texels + at;
  vec4 gradient = TakeGradients(at);
  vec4 parameter = texelFetch(parameter_texels, int(at));
  vec4 first = texelFetch(moment_texels, int(moment));
  vec4 second = texelFetch(moment_texels, int(moment + texels));
#define UpdateComponent(i)                                                               \
  Put(4u * at + i, 4u * moment + i,                                                      \
      Next(AdamState(parameter[i], first[i], second[i]), gradient[i], row, 4u * texel + i));
  UpdateComponent(0) UpdateComponent(1) UpdateComponent(2) UpdateComponent(3)
}

void main() {
  uint row = ThreadIndex();
  TETREC_RARELY(row < push.row_count && has_gradients[row] != 0u) {
    has_gradients[row] = 0u;
    uint texel = 0u;
    while (texel < push.stride / 4u) {
      UpdateTexel(row, texel);
      texel += 1u;
    }
  }
}
