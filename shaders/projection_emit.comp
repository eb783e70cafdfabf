// Writes one item (tile, tet) for every tile that a tet of a stretch meets, tets in sorted order.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "projection.glsl"
#include "thread_index.glsl"

layout(std430, binding = kBindItems) readonly buffer Items { uint items[]; };
layout(std430, binding = kBindRectangles) readonly buffer Rectangles { uvec2 rectangles[]; };
layout(std430, binding = kBindOffsets) readonly buffer Offsets { uint offsets[]; };
layout(std430, binding = kBindSortedKeys) writeonly buffer Tiles { uint tile_of_item[]; };
layout(std430, binding = kBindSortedItems) writeonly buffer Tets { uint tet_of_item[]; };

void main() {
  uint i = ThreadIndex();
  bool exists = i < push.count;
  uint place = push.first + (exists ? i : 0u);
  uint tet = items[place];
  uvec2 first = FirstOf(rectangles[tet]), size = SizeOf(rectangles[tet]);
  uint item = offsets[place - push.offsets_first] - offsets[push.first - push.offsets_first];
  uint columns = TileGrid().x;
  uint k = 0u;
  uint tiles = exists ? size.x * size.y : 0u;
  while (k < tiles) {
    uvec2 tile = first + uvec2(k % size.x, k / size.x);
    tile_of_item[item + k] = tile.y * columns + tile.x;
    tet_of_item[item + k] = tet;
    k += 1u;
  }
}
