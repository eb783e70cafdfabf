// Sets values to 0.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { ScanPush push; };
layout(std430, binding = kBindValues) writeonly buffer Values { uint values[]; };

void main() {
  if (gl_GlobalInvocationID.x < push.count) values[gl_GlobalInvocationID.x] = 0u;
}
