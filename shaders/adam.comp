// One step of Adam (shared/adam.glsl.h) on colour and density of every row, and the field that the
// renderers read.
//
// A row of parameters, of gradients, and of first and of second moments has kRowComponents floats,
// in the order of the layout (field/layout.h). Gradients are by value: those of a parameter p whose
// value is e^p are dL/dp = e^p dL/dvalue. Clears the gradients for the next step.
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
layout(std430, binding = kBindVertexGradients) buffer VertexGradients { float vertex_gradients[]; };
#endif
layout(std430, binding = kBindParameters) buffer Parameters { float parameters[]; };
layout(std430, binding = kBindMoments) buffer Moments { float moments[]; };  // a row's first, its second
layout(std430, binding = kBindVertices) buffer Vertices { vec4 vertices[]; };
layout(std430, binding = kBindRateShares) readonly buffer RateShares { float rate_shares[]; };
layout(push_constant) uniform Push { AdamPush push; };

#include "storage.glsl"

// Reads a gradient and clears it.
float TakeGradient(uint at, float quantum) {
#ifdef TETREC_FIXED_POINT
  float gradient = quantum * float(vertex_gradients[at]);
  vertex_gradients[at] = 0;
#else
  float gradient = vertex_gradients[at];
  vertex_gradients[at] = 0.0;
#endif
  return gradient;
}

// Set if any gradient of the row is not 0; and the logarithm of its density before decay and bounds.
bool seen = false;
float log_density = 0.0;

// One component of a row. All but `row` are constants to the compiler.
void Update(uint row, int component, int rate_class) {
  uint first = row * uint(kRowComponents);
  uint at = first + uint(component), moment = first + at;
  float parameter = parameters[at];
  float gradient = TakeGradient(at, push.quanta[rate_class]);
  if (component == kDensityComponent) {
    gradient *= vertices[DensityRow(row, push.first_cell)].w;
  }
  seen = seen || gradient != 0.0;
  AdamState state =
      AdamStep(AdamState(parameter, moments[moment], moments[moment + uint(kRowComponents)]),
               AdamRates(push.beta1, push.beta2, push.epsilon, push.second_moment_correction),
               rate_shares[row] * push.rates[rate_class], gradient);
  moments[moment] = state.first;
  moments[moment + uint(kRowComponents)] = state.second;
  if (component == kDensityComponent) {
    log_density = state.parameter;
  } else {
    parameter = ClampColor(state.parameter);
    parameters[at] = parameter;
    vertices[ColorRow(row, push.first_cell)][component] = parameter;
  }
}

void main() {
  uint row = ThreadIndex();
  if (row < push.row_count) {
    Update(row, kColorComponent, kRateColor);
    Update(row, kColorComponent + 1, kRateColor);
    Update(row, kColorComponent + 2, kRateColor);
    Update(row, kDensityComponent, kRateDensity);
    // Seen rows tend to empty: what the pictures do not ask for again and again goes.
    if (seen) log_density -= rate_shares[row] * push.density_decay;
    log_density = ClampLog(log_density, push.least_log, push.largest_log);
    parameters[row * uint(kRowComponents) + kDensityComponent] = log_density;
    vertices[DensityRow(row, push.first_cell)].w = exp(log_density);
  }
}
