// Cutting a batch into tiles whose fragments fit into a buffer.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <functional>
#include <vector>

namespace tetrec {

// Pixels [x, x + width) x [y, y + height) of a batch, counted from its first pixel.
struct FragmentTile {
  uint32_t x = 0, y = 0, width = 0, height = 0;
  uint64_t fragments = 0;
  uint32_t longest_list = 0;
};

// Tiles are whole rows, as many as fit; a row that does not fit alone is cut into parts. A tile
// exceeds `capacity` only if it is a single pixel.
std::vector<FragmentTile> CutIntoTiles(uint32_t width, uint32_t height, uint64_t capacity,
                                       const std::function<uint32_t(uint32_t, uint32_t)>& count_at);

}  // namespace tetrec
