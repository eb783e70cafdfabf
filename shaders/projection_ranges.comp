// Finds where each tile's stretch of the sorted items starts and ends; all ranges must be (0, 0)
// before.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "projection.glsl"

layout(std430, binding = kBindKeys) readonly buffer Keys { uint tile_of_item[]; };
layout(std430, binding = kBindTileRanges) writeonly buffer TileRanges { uint tile_ranges[]; };

void main() {
  uint i = gl_GlobalInvocationID.x * kItemRun;
  uint end = min(i + kItemRun, push.count);
  while (i < end) {
    uint tile = tile_of_item[i];
    if (i == 0u || tile_of_item[max(i, 1u) - 1u] != tile) tile_ranges[2u * tile] = i;
    if (i + 1u == push.count || tile_of_item[min(i + 1u, push.count - 1u)] != tile) {
      tile_ranges[2u * tile + 1u] = i + 1u;
    }
    i += 1u;
  }
}
