// Radix sort: counts how often each digit occurs in each run of keys. The counts of a digit are
// side by side, so that their prefix sums are the places where the runs' keys go.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { SortPush push; };
layout(std430, binding = kBindKeys) readonly buffer Keys { uint keys[]; };
layout(std430, binding = kBindDigitCounts) buffer DigitCounts { uint digit_counts[]; };

void main() {
  uint run = gl_GlobalInvocationID.x;
  uint i = run * kSortRun;
  uint end = min(i + kSortRun, push.count);
  uint digits = run < push.runs ? kSortDigits : 0u;
  uint d = 0u;
  while (d < digits) {
    digit_counts[d * push.runs + run] = 0u;
    d += 1u;
  }
  while (i < end) {
    uint digit = (keys[i] >> push.shift) & (kSortDigits - 1u);
    digit_counts[digit * push.runs + run] += 1u;
    i += 1u;
  }
}
