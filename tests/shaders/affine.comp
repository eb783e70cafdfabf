// out[i] = factor in[i] + 1: shows in which order two dispatches ran.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "thread_index.glsl"
layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer In { uint source[]; };
layout(std430, binding = 1) buffer Out { uint target[]; };
layout(push_constant) uniform Push { uint count, factor; };

void main() {
  uint i = ThreadIndex();
  if (i < count) target[i] = factor * source[i] + 1u;
}
