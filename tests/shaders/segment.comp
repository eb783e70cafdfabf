// The shared segment integral as a kernel computes it, for comparison with C++.
#version 460
#extension GL_GOOGLE_include_directive : require
layout(push_constant) uniform Push { uint ray_count; } push;
#define TETREC_NEVER (push.ray_count == 0u)
#include "integral.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 0) readonly buffer In { vec2 ends[]; };
layout(std430, binding = 1) writeonly buffer Out { vec4 results[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i < push.ray_count) {
    vec2 s = ends[i];
    SegmentWeights weights = IntegrateSegmentBy(kIntegral, kSplits, s.x, s.y);
    SegmentAdjoint adjoint = IntegrateSegmentByWithDerivatives(kIntegral, kSplits, s.x, s.y);
    results[3u * i] = vec4(weights.w0, weights.w1, adjoint.w0, adjoint.w1);
    results[3u * i + 1u] = vec4(adjoint.dw0_ds0, adjoint.dw0_ds1, adjoint.dw1_ds0, adjoint.dw1_ds1);
    results[3u * i + 2u] = vec4(exp(-s.x), sqrt(s.x), 1.0 / s.x, 0.0);
  }
}
