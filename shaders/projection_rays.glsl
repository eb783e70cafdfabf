// The rays of a rectangle, tile by tile, each with a window of its tile's list: at most push.count
// of the sorted items, from number push.first on.
#define TETREC_NEVER (push.rays.ray_count == 0u)

#include "projection.glsl"
#include "rays.glsl"
#include "integral.glsl"

layout(binding = kBindTets) uniform utextureBuffer tets;
layout(binding = kBindVertices) uniform textureBuffer vertices;
#include "cells.glsl"
layout(std430, binding = kBindItems) readonly buffer Items { uint tet_of_item[]; };
layout(std430, binding = kBindTileRanges) readonly buffer TileRanges { uvec2 tile_ranges[]; };

#include "tet_cut.glsl"

struct TileRay {
  bool exists;
  uint index;   // in the batch
  uvec2 range;  // of items
};

TileRay FindTileRay(uint thread) {
  uint tile = thread / kTileRays, block_of_tile = thread % kTileRays / kBlockRays;
  uvec2 grid = TileGrid();
  uint column = tile % grid.x * kTileColumns + block_of_tile % kTileColumns;
  uint row = tile / grid.x * kTileRows + block_of_tile / kTileColumns;
  TileRay ray;
  ray.exists = column < push.block_columns && row < push.block_rows;
  ray.index = ray.exists ? (row * push.block_columns + column) * kBlockRays + thread % kBlockRays : 0u;
  uvec2 list = ray.exists ? tile_ranges[tile] : uvec2(0u);
  uint begin = min(list.x + push.first, list.y);
  ray.range = uvec2(begin, begin + min(push.count, list.y - begin));
  return ray;
}

// Starts `push.start` ahead of the camera, so that the precision of coordinates in its frame is
// relative to the size of the mesh.
Ray MakeMovedRay(uint index) {
  Ray ray = MakeRay(index);
  ray.origin += push.start * ray.direction;
  return ray;
}
