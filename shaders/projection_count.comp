// Counts the tiles that each tet of a stretch meets, in sorted order.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "projection.glsl"
#include "thread_index.glsl"

layout(std430, binding = kBindItems) readonly buffer Items { uint items[]; };
layout(std430, binding = kBindRectangles) readonly buffer Rectangles { uvec2 rectangles[]; };
layout(std430, binding = kBindOffsets) writeonly buffer Offsets { uint offsets[]; };

void main() {
  uint i = ThreadIndex();
  if (i <= push.count) {
    uvec2 size = i < push.count ? SizeOf(rectangles[items[push.first + i]]) : uvec2(0u);
    offsets[i] = size.x * size.y;
  }
}
