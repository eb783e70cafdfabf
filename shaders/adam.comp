// One step of Adam (shared/adam.glsl.h) on colour and density of every row, and the field that the
// renderers read.
//
// A row of parameters, of gradients, and of first and of second moments has kRowComponents floats,
// in the order of the layout (field/layout.h). Gradients are by value: those of a parameter p are
// dL/dp = dvalue/dp dL/dvalue. Clears the gradients for the next step.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef TETREC_FIXED_POINT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif
#define TETREC_NEVER (push.row_count == 0u)
#include "shared/adam.glsl.h"
#include "shared/gpu_types.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
#ifdef TETREC_FIXED_POINT
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { int64_t vertex_gradients[]; };
#else
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { float vertex_gradients[]; };
#endif
layout(std430, binding = kBindParameters) buffer Parameters { float parameters[]; };
layout(std430, binding = kBindMoments) buffer Moments { float moments[]; };  // a row's first, its second
layout(std430, binding = kBindVertices) buffer Vertices { vec4 vertices[]; };
// The same rows as texels, whole: word by word lavapipe takes 2.5 times as long for the update.
layout(binding = kBindGradientTexels) uniform textureBuffer gradient_texels;
layout(binding = kBindParameterTexels) uniform textureBuffer parameter_texels;
layout(binding = kBindMomentTexels) uniform textureBuffer moment_texels;
layout(binding = kBindRowRateTexels) uniform textureBuffer row_rates;
layout(push_constant) uniform Push { AdamPush push; };

#include "storage.glsl"
#include "density.glsl"

// dL/dvalue of a row; clears it.
vec4 TakeGradients(uint row) {
  uint at = uint(kRowComponents) * row;
#ifdef TETREC_FIXED_POINT
  vec4 gradient;
  uint i = 0u;
  while (i < uint(kRowComponents)) {
    float quantum = push.quanta[i == kDensityComponent ? kRateDensity : kRateColor];
    gradient[i] = quantum * float(vertex_gradients[at + i]);
    vertex_gradients[at + i] = 0;
    i += 1u;
  }
#else
  vec4 gradient = texelFetch(gradient_texels, int(row));
  TETREC_RARELY(gradient != vec4(0.0)) {
    vertex_gradients[at] = 0.0;
    vertex_gradients[at + 1u] = 0.0;
    vertex_gradients[at + 2u] = 0.0;
    vertex_gradients[at + 3u] = 0.0;
  }
#endif
  return gradient;
}

AdamState Next(vec4 parameter, vec4 first, vec4 second, int component, float rate, vec4 gradient) {
  return AdamStep(AdamState(parameter[component], first[component], second[component]),
                  AdamRates(push.beta1, push.beta2, push.epsilon, push.second_moment_correction),
                  rate, gradient[component]);
}

void main() {
  uint row = ThreadIndex();
  if (row < push.row_count) {
    vec4 parameter = texelFetch(parameter_texels, int(row));
    vec4 first = texelFetch(moment_texels, int(2u * row));
    vec4 second = texelFetch(moment_texels, int(2u * row + 1u));
    vec4 gradient = TakeGradients(row);
    gradient[kDensityComponent] *=
        SlopeOfDensity(parameter[kDensityComponent], push.density_scale);
    vec3 rates = texelFetch(row_rates, int(row)).xyz;
    float share = rates.x, kept_density = rates.y, least_of_row = rates.z;
    float color_rate = share * push.rates[kRateColor];
    AdamState r = Next(parameter, first, second, kColorComponent, color_rate, gradient);
    AdamState g = Next(parameter, first, second, kColorComponent + 1, color_rate, gradient);
    AdamState b = Next(parameter, first, second, kColorComponent + 2, color_rate, gradient);
    AdamState density = Next(parameter, first, second, kDensityComponent,
                             share * push.rates[kRateDensity], gradient);
    vec3 color = vec3(ClampColor(r.parameter), ClampColor(g.parameter), ClampColor(b.parameter));
    // Seen rows tend to empty: what the pictures do not ask for again and again goes.
    if (gradient != vec4(0.0)) {
      density.parameter =
          DecayedDensity(density.parameter, share * push.density_decay, kept_density);
    }
    density.parameter = ClampBetween(density.parameter, max(push.least_density, least_of_row),
                                     push.largest_density);
    if (kDensityActivation == kActivationSigned) {
      density = StopAtZero(density, parameter[kDensityComponent]);
    }

    uint at = uint(kRowComponents) * row, first_at = 2u * at, second_at = 2u * at + uint(kRowComponents);
    parameters[at] = color.r;
    parameters[at + 1u] = color.g;
    parameters[at + 2u] = color.b;
    parameters[at + 3u] = density.parameter;
    moments[first_at] = r.first;
    moments[first_at + 1u] = g.first;
    moments[first_at + 2u] = b.first;
    moments[first_at + 3u] = density.first;
    moments[second_at] = r.second;
    moments[second_at + 1u] = g.second;
    moments[second_at + 2u] = b.second;
    moments[second_at + 3u] = density.second;
    vertices[DensityRow(row, push.first_cell)].w =
        DensityOfParameter(density.parameter, push.density_scale);
    vertices[ColorRow(row, push.first_cell)].rgb = color;
  }
}
