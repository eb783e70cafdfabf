// Prefix sums, downwards: every value becomes the sum of those before it.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { ScanPush push; };
layout(std430, binding = kBindValues) buffer Values { uint values[]; };
layout(std430, binding = kBindSums) readonly buffer Sums { uint sums[]; };

void main() {
  uint run = gl_GlobalInvocationID.x;
  uint i = run * kScanRun;
  uint end = min(i + kScanRun, push.count);
  uint sum = push.has_sums != 0u && i < push.count ? sums[run] : 0u;
  while (i < end) {
    uint value = values[i];
    values[i] = sum;
    sum += value;
    i += 1u;
  }
}
