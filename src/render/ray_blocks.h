// Pictures as 4 x 2 blocks of rays.
#pragma once

#include "render/renderer.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace tetrec {

// 4 x 2 blocks that cover width x height of view `view`, row of blocks by row.
std::vector<RayBlock> CoveringBlocks(int width, int height, uint32_t view = 0);

// Pixel (x, y) of ray `ray` of the batch of `blocks`.
glm::ivec2 PixelOfRay(std::span<const RayBlock> blocks, size_t ray);

// Blocks a row where `blocks` are a tile: a rectangle of one view, row of blocks by row. Else 0.
uint32_t TileColumns(std::span<const RayBlock> blocks);

}  // namespace tetrec
