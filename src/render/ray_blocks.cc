// Images as 4 x 2 blocks of rays.
#include "render/ray_blocks.h"

#include "core/error.h"

#include <algorithm>
#include <cstdint>

namespace tetrec {

std::vector<RayBlock> CoveringBlocks(int width, int height, uint32_t view) {
  std::vector<RayBlock> blocks;
  for (int y = 0; y < height; y += kRayBlockHeight) {
    for (int x = 0; x < width; x += kRayBlockWidth) {
      blocks.push_back({view, uint32_t(x), uint32_t(y)});
    }
  }
  return blocks;
}

void SortByPlace(std::span<RayBlock> blocks) {
  // Numbers that sort as (view, tile of 32 x 32 pixels, place in it) do, and contain the block:
  // they sort in half the time that blocks take by such tuples.
  constexpr uint32_t kTileBits = 5, kTile = 1u << kTileBits, kMostTiles = 1u << 11;
  std::vector<uint64_t> places(blocks.size());
  for (size_t i = 0; i < blocks.size(); ++i) {
    const auto& [view, x, y, slot] = blocks[i];
    TETREC_CHECK(x / kTile < kMostTiles && y / kTile < kMostTiles,
                 "coordinates of blocks are below 65,536");
    const uint32_t tile = y / kTile * kMostTiles + x / kTile;
    const uint32_t in_tile = y % kTile * kTile + x % kTile;
    places[i] = uint64_t{view} << 32 | tile << 2 * kTileBits | in_tile;
  }
  std::ranges::sort(places);
  for (size_t i = 0; i < blocks.size(); ++i) {
    const uint32_t place = uint32_t(places[i]);
    const uint32_t tile = place >> 2 * kTileBits;
    blocks[i] = {.view = uint32_t(places[i] >> 32),
                 .x = tile % kMostTiles * kTile + place % kTile,
                 .y = tile / kMostTiles * kTile + (place >> kTileBits) % kTile};
  }
}

glm::ivec2 PixelOfRay(std::span<const RayBlock> blocks, size_t ray) {
  const RayBlock& block = blocks[ray / kRaysPerBlock];
  const int lane = int(ray % kRaysPerBlock);
  return {int(block.x) + lane % kRayBlockWidth, int(block.y) + lane / kRayBlockWidth};
}

uint32_t TileColumns(std::span<const RayBlock> blocks) {
  if (blocks.empty()) return 0;
  const RayBlock& first = blocks[0];
  size_t columns = 1;
  while (columns < blocks.size() && blocks[columns].y == first.y) ++columns;
  if (blocks.size() % columns != 0) return 0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    const bool in_place = blocks[i].view == first.view &&
                          blocks[i].x == first.x + i % columns * kRayBlockWidth &&
                          blocks[i].y == first.y + i / columns * kRayBlockHeight;
    if (!in_place) return 0;
  }
  return uint32_t(columns);
}

}  // namespace tetrec
