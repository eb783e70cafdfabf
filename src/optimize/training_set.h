// The views that a field learns from, and which blocks of their pixels to draw.
#pragma once

#include "render/renderer.h"
#include "scene/scene.h"

#include <cstdint>
#include <vector>

namespace tetrec {

struct TrainingSet {
  std::vector<RenderView> views;
  std::vector<TargetImage> targets;
  std::vector<RayBlock> blocks;          // every aligned 4 x 2 block of every view
  std::vector<uint32_t> subject_blocks;  // those that show something, or lie beside it
  uint64_t pixels = 0;
};

// Reads and premultiplies the pictures of a split on all cores; pixels that masks leave out are
// kNotJudgedTarget. Throws DataError (no view, picture of another size than its camera, smaller
// than a block, masks that leave nothing).
TrainingSet LoadTrainingSet(const std::filesystem::path& scene_folder, const Scene& scene,
                            const std::vector<int>& views);

RenderView MakeRenderView(const Scene& scene, int view);

// Draws the blocks of one step: `subject_share` of them from subject_blocks. Depends on seed and
// iteration only, so a resumed run draws what the first would have drawn.
std::vector<RayBlock> DrawBlocks(const TrainingSet& set, size_t count, double subject_share,
                                 uint64_t seed, uint64_t iteration);

// `tiles` rectangles of about `count` blocks each, all of one shape, around blocks drawn as by
// DrawBlocks, each row by row; none wider or higher than the smallest picture where there are
// several, or than its own where there is one.
struct DrawnTiles {
  std::vector<RayBlock> blocks;
  TileShape shape;
};
DrawnTiles DrawTiles(const TrainingSet& set, size_t tiles, size_t count, double subject_share,
                     uint64_t seed, uint64_t iteration);

}  // namespace tetrec
