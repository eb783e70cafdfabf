// Images as 4 x 2 blocks of rays.
#include "render/ray_blocks.h"

#include <algorithm>
#include <tuple>

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
  constexpr uint32_t kTile = 32;  // [px]
  const auto place = [](const RayBlock& block) {
    return std::tuple(block.view, block.y / kTile, block.x / kTile, block.y, block.x);
  };
  std::ranges::sort(blocks, {}, place);
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
