// Prefix sums, upwards: the total of every run of values.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { ScanPush push; };
layout(std430, binding = kBindValues) readonly buffer Values { uint values[]; };
layout(std430, binding = kBindSums) writeonly buffer Sums { uint sums[]; };

void main() {
  uint run = gl_GlobalInvocationID.x;
  uint i = run * kScanRun;
  uint end = min(i + kScanRun, push.count);
  bool exists = i < push.count;
  uint sum = 0u;
  while (i < end) {
    sum += values[i];
    i += 1u;
  }
  if (exists) sums[run] = sum;
}
