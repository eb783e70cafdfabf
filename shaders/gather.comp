// Looks up the key of every item in a table.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { ScanPush push; };
layout(std430, binding = kBindTable) readonly buffer Table { uint table[]; };
layout(std430, binding = kBindItems) readonly buffer Items { uint items[]; };
layout(std430, binding = kBindKeys) writeonly buffer Keys { uint keys[]; };

void main() {
  uint i = ThreadIndex();
  if (i < push.count) keys[i] = table[items[i]];
}
