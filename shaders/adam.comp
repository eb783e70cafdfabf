// One step of Adam (shared/adam.glsl.h) on every vertex, and the field that the renderers read.
//
// Parameters: colour as it is, and the logarithm of density; dL/dlog(sigma) = sigma dL/dsigma.
// Clears the gradient for the next step.
#version 460
#extension GL_GOOGLE_include_directive : require
#ifdef TETREC_FIXED_POINT
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#endif
#include "shared/adam.glsl.h"
#include "shared/gpu_types.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
#ifdef TETREC_FIXED_POINT
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { int64_t vertex_gradients[]; };
#else
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { vec4 vertex_gradients[]; };
#endif
layout(std430, binding = kBindParameters) buffer Parameters { vec4 parameters[]; };
layout(std430, binding = kBindMoments) buffer MomentsBuffer { Moments moments[]; };
layout(std430, binding = kBindVertices) buffer Vertices { vec4 vertices[]; };
layout(push_constant) uniform Push { AdamPush push; };

#include "storage.glsl"

// Reads the gradient of a vertex and clears it.
vec4 TakeGradient(uint v) {
#ifdef TETREC_FIXED_POINT
  vec4 gradient;
  uint i = 0u;
  while (i < 4u) {
    gradient[i] = float(vertex_gradients[4u * v + i]);
    vertex_gradients[4u * v + i] = 0;
    i += 1u;
  }
  return gradient * vec4(vec3(push.color_quantum), push.density_quantum);
#else
  vec4 gradient = vertex_gradients[v];
  vertex_gradients[v] = vec4(0.0);
  return gradient;
#endif
}

void main() {
  uint v = ThreadIndex();
  if (v < push.row_count) {
    vec4 parameter = parameters[v];
    vec4 gradient = TakeGradient(v);
    gradient.a *= vertices[DensityRow(v)].w;
    Moments m = moments[v];
    AdamRates rates =
        AdamRates(push.beta1, push.beta2, push.epsilon, push.second_moment_correction);
    vec4 rate = vec4(vec3(push.color_rate), push.density_rate);
    uint i = 0u;
    while (i < 4u) {
      AdamState state =
          AdamStep(AdamState(parameter[i], m.first[i], m.second[i]), rates, rate[i], gradient[i]);
      parameter[i] = state.parameter;
      m.first[i] = state.first;
      m.second[i] = state.second;
      i += 1u;
    }
    // Seen vertices tend to empty: what the pictures do not ask for again and again goes.
    if (gradient != vec4(0.0)) parameter.a -= push.density_decay;
    parameter.r = ClampColor(parameter.r);
    parameter.g = ClampColor(parameter.g);
    parameter.b = ClampColor(parameter.b);
    parameter.a = ClampLogDensity(parameter.a, push.max_log_density);
    moments[v] = m;
    parameters[v] = parameter;
    vertices[DensityRow(v)].w = exp(parameter.a);
    vertices[ColorRow(v)].rgb = parameter.rgb;
  }
}
