// Radix sort: moves every key and its item to its place. A run moves its keys in order, so the sort
// is stable.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { SortPush push; };
layout(std430, binding = kBindKeys) readonly buffer Keys { uint keys[]; };
layout(std430, binding = kBindItems) readonly buffer Items { uint items[]; };
layout(std430, binding = kBindSortedKeys) writeonly buffer SortedKeys { uint sorted_keys[]; };
layout(std430, binding = kBindSortedItems) writeonly buffer SortedItems { uint sorted_items[]; };
layout(std430, binding = kBindDigitCounts) buffer DigitCounts { uint digit_places[]; };

void main() {
  uint run = gl_GlobalInvocationID.x;
  uint i = run * kSortRun;
  uint end = min(i + kSortRun, push.count);
  while (i < end) {
    uint key = keys[i];
    uint digit = (key >> push.shift) & (kSortDigits - 1u);
    uint place = digit_places[digit * push.runs + run];
    digit_places[digit * push.runs + run] = place + 1u;
    sorted_keys[place] = key;
    sorted_items[place] = items[i];
    i += 1u;
  }
}
