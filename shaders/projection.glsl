// The rectangle of rays and its tiles, as all kernels of projected tets see them.

#include "shared/gpu_types.glsl.h"

layout(local_size_x = kWorkgroupSize) in;
layout(push_constant) uniform Push { ProjectionPush push; };

// Columns and rows of tiles.
uvec2 TileGrid() {
  return uvec2((push.block_columns + kTileColumns - 1u) / kTileColumns,
               (push.block_rows + kTileRows - 1u) / kTileRows);
}

// First and last (column, row) of the tiles that a tet's projection meets, in two words.
uvec2 PackRectangle(uvec2 first, uvec2 last) { return first | last << 16u; }
uvec2 FirstOf(uvec2 rectangle) { return rectangle & 0xFFFFu; }
uvec2 SizeOf(uvec2 rectangle) { return (rectangle >> 16u) + 1u - FirstOf(rectangle); }
