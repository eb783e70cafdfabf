// Images as 4 x 2 blocks of rays.
#pragma once

#include "render/training_renderer.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace tetrec {

// 4 x 2 blocks that cover width x height pixels of view `view`, in row order.
std::vector<RayBlock> CoveringBlocks(int width, int height, uint32_t view = 0);

// Sorts by view and place, so that rays that follow each other pass the same tets: these are then
// in the cache. Slots are lost. Coordinates are below 65,536.
void SortByPlace(std::span<RayBlock> blocks);

// The pixel (x, y) of ray number `ray` of a batch.
glm::ivec2 PixelOfRay(std::span<const RayBlock> blocks, size_t ray);

// Blocks per row if `blocks` are a tile: a rectangle of one view in row order. Otherwise 0.
uint32_t TileColumns(std::span<const RayBlock> blocks);

}  // namespace tetrec
