// Lists the visible tets in the order of their numbers.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "projection.glsl"
#include "thread_index.glsl"

layout(std430, binding = kBindVisible) readonly buffer Visible { uint before[]; };
layout(std430, binding = kBindItems) writeonly buffer Items { uint items[]; };

void main() {
  uint tet = ThreadIndex();
  if (tet < push.count) {
    uint place = before[tet];
    if (before[tet + 1u] != place) items[place] = tet;
  }
}
