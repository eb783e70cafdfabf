// Copies every node that the faces wrote into the list of its ray.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "shared/gpu_types.glsl.h"
#include "thread_index.glsl"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { PpllPush push; };
layout(std430, binding = kBindLists) readonly buffer Lists { uvec2 lists[]; };
layout(std430, binding = kBindAppended) readonly buffer Appended { uvec4 appended[]; };
layout(std430, binding = kBindFragments) writeonly buffer Fragments { uvec2 fragments[]; };

void main() {
  uint i = ThreadIndex();
  if (i < push.most_appended) {
    uvec4 node = appended[i];
    fragments[lists[node.z].x + node.w] = node.xy;
  }
}
