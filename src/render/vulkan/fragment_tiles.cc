// Cutting a batch into tiles whose fragments fit into a buffer.
#include "render/vulkan/fragment_tiles.h"

#include <algorithm>

namespace tetrec {
namespace {

using CountAt = std::function<uint32_t(uint32_t, uint32_t)>;

// The parts of row y.
std::vector<FragmentTile> CutRow(uint32_t width, uint32_t y, uint64_t capacity,
                                 const CountAt& count_at) {
  std::vector<FragmentTile> parts;
  for (uint32_t x = 0; x < width; ++x) {
    const uint32_t count = count_at(x, y);
    if (parts.empty() || parts.back().fragments + count > capacity) parts.push_back({x, y, 0, 1});
    FragmentTile& part = parts.back();
    ++part.width;
    part.fragments += count;
    part.longest_list = std::max(part.longest_list, count);
  }
  return parts;
}

}  // namespace

std::vector<FragmentTile> CutIntoTiles(uint32_t width, uint32_t height, uint64_t capacity,
                                       const CountAt& count_at) {
  std::vector<FragmentTile> tiles;
  for (uint32_t y = 0; y < height; ++y) {
    const std::vector<FragmentTile> parts = CutRow(width, y, capacity, count_at);
    const bool joins = parts.size() == 1 && !tiles.empty() && tiles.back().width == width &&
                       tiles.back().fragments + parts[0].fragments <= capacity;
    if (!joins) {
      tiles.insert(tiles.end(), parts.begin(), parts.end());
      continue;
    }
    FragmentTile& tile = tiles.back();
    ++tile.height;
    tile.fragments += parts[0].fragments;
    tile.longest_list = std::max(tile.longest_list, parts[0].longest_list);
  }
  return tiles;
}

}  // namespace tetrec
