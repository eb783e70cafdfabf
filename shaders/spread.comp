// Fills density and colour of the field that the renderers read from its parameters, by the very
// arithmetic of adam.comp: a field read back and set again is the same to the bit.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(std430, binding = kBindParameters) readonly buffer Parameters { vec4 parameters[]; };
layout(std430, binding = kBindVertices) buffer Vertices { vec4 vertices[]; };
layout(push_constant) uniform Push { SpreadPush push; };

#include "storage.glsl"

void main() {
  uint v = ThreadIndex();
  if (v < push.row_count) {
    vec4 parameter = parameters[v];
    vertices[DensityRow(v)].w = exp(parameter.a);
    vertices[ColorRow(v)].rgb = parameter.rgb;
  }
}
