// The views that a field is fitted to, and the choice of blocks of their pixels.
#pragma once

#include "render/training_renderer.h"
#include "scene/scene.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Every aligned 4 x 2 block of some views, view by view and row by row. They are computed, not
// stored: a list would take 1.5 bytes per pixel.
class AlignedBlocks {
 public:
  // Views are added in ascending order. `width`, `height`: of the view's image [px].
  void Add(uint32_t view, int width, int height);
  size_t size() const { return views_.empty() ? 0 : views_.back().end; }
  RayBlock operator[](size_t index) const;
  struct Range {
    size_t begin, end;
  };
  // The indices of a view's blocks.
  Range OfView(uint32_t view) const;
  std::vector<RayBlock> List() const;

 private:
  struct BlocksOfView {
    size_t begin, end;  // indices of its blocks
    uint32_t view, columns;
  };
  std::vector<BlocksOfView> views_;
};

struct TrainingSet {
  std::vector<RenderView> views;
  std::vector<TargetImage> targets;
  AlignedBlocks blocks;                  // of the listed views
  std::vector<uint32_t> subject_blocks;  // those that show something, or are next to one
  uint64_t pixels = 0;
  bool has_masks = false;  // if so, only subject_blocks contain pixels to learn from
};

// The pixels of subject_blocks, so of the listed views; all pixels if there are no such blocks.
uint64_t SubjectPixels(const TrainingSet& set);

// The listed blocks to learn from, and the number of their pixels: all blocks, or, with masks,
// subject_blocks.
std::vector<RayBlock> LearnedBlocks(const TrainingSet& set);
uint64_t LearnedPixels(const TrainingSet& set);

// Reads and premultiplies the images of a split on all cores; pixels that masks exclude are
// kNotJudgedTarget. Throws DataError (no views, an image whose size differs from its camera's or is
// below that of a block, masks that exclude everything).
TrainingSet LoadTrainingSet(const std::filesystem::path& scene_folder, const Scene& scene,
                            const std::vector<int>& views);

// Lists the blocks of all views but those whose flag is set; of all views if there are no flags.
void ListBlocks(TrainingSet& set, std::span<const uint8_t> left_out);

RenderView MakeRenderView(const Scene& scene, int view);

// Draws the blocks of one step, `subject_share` of them, or with masks all, from subject_blocks.
// The result depends only on seed and iteration, so a resumed run draws what the first one would
// have drawn.
std::vector<RayBlock> DrawBlocks(const TrainingSet& set, size_t count, double subject_share,
                                 uint64_t seed, uint64_t iteration);

// As DrawBlocks, but of at most `views` views, which are drawn first: as often as DrawBlocks draws
// their blocks. The blocks come view by view.
std::vector<RayBlock> DrawBlocksOfViews(const TrainingSet& set, size_t count, size_t views,
                                        double subject_share, uint64_t seed, uint64_t iteration);

// `tiles` rectangles of about `count` blocks each, all of one shape, around blocks drawn as by
// DrawBlocks, each with its blocks in row order. Several are no wider or higher than the smallest
// image, a single one no wider or higher than its own.
struct DrawnTiles {
  std::vector<RayBlock> blocks;
  TileShape shape;
};
DrawnTiles DrawTiles(const TrainingSet& set, size_t tiles, size_t count, double subject_share,
                     uint64_t seed, uint64_t iteration);

}  // namespace tetrec
