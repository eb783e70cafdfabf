// The batches of rays that training steps draw.
#include "optimize/batches.h"

#include "core/error.h"
#include "core/random.h"
#include "render/ray_blocks.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

// Blocks per D-SSIM tile if a batch consists of several tiles: 32 x 32 pixels.
constexpr size_t kTileBlocks = 128;
constexpr int kLeastDssimPicture = 12;  // [px] whole blocks with room for a window

glm::vec3 DrawColor(uint64_t seed, uint64_t iteration) {
  Random random(seed ^ 0xB0Cull, iteration);
  const float r = float(random.Uniform()), g = float(random.Uniform()), b = float(random.Uniform());
  return {r, g, b};
}

void CheckRoomForWindows(const TrainingSet& set, const std::filesystem::path& scene_folder) {
  for (const TargetImage& target : set.targets) {
    if (std::min(target.width, target.height) >= kLeastDssimPicture) continue;
    throw DataError(
        fmt::format("{}: an image of {}x{} px is too small for D-SSIM, which needs {}; choose the "
                    "loss l1 or l2",
                    scene_folder.string(), target.width, target.height, kLeastDssimPicture));
  }
}

}  // namespace

BatchDrawer::BatchDrawer(const OptimizeOptions& options, const TrainingSet& set,
                         const TrainingRenderer& renderer, const glm::vec3& background_srgb,
                         const std::filesystem::path& scene_folder)
    : options_(options),
      set_(set),
      pace_(renderer.Pace()),
      needs_tiles_(renderer.NeedsTiles()),
      background_srgb_(background_srgb) {
  if (options.loss.dssim > 0) CheckRoomForWindows(set, scene_folder);
}

TrainingBatch BatchDrawer::Draw(uint64_t iteration, int samples) {
  TrainingBatch batch;
  batch.tiles = DrawBlocksOrTiles(iteration);
  batch.samples = samples;
  if (samples > 1) RefineBlocks(iteration, samples);
  batch.blocks = blocks_;
  batch.loss = options_.loss.pixel;
  batch.dssim_weight = float(options_.loss.dssim);
  batch.background_srgb = Background(iteration);
  batch.jitter_px = float(options_.jitter_px);
  batch.seed = uint32_t(Random(options_.seed, iteration ^ 0x717u).Next());
  return batch;
}

glm::vec3 BatchDrawer::Background(uint64_t iteration) const {
  return options_.background == BackgroundChoice::kScene ? background_srgb_
                                                         : DrawColor(options_.seed, iteration);
}

size_t BatchDrawer::CountOfBatch(std::span<const RayBlock> blocks, size_t most) const {
  TETREC_CHECK(most > 0 && pace_.views_per_batch > 0, "a batch has blocks");
  if (!few_views_) return std::min(most, blocks.size());
  size_t count = 0, views = 0;
  while (count < most && count < blocks.size()) {
    views += count == 0 || blocks[count].view != blocks[count - 1].view;
    if (views > pace_.views_per_batch) break;
    ++count;
  }
  return count;
}

// Fills blocks_; returns the shape of its tiles, if it consists of tiles.
TileShape BatchDrawer::DrawBlocksOrTiles(uint64_t iteration) {
  const size_t count = size_t(rays_per_step()) / kRaysPerBlock;
  if (!DrawsTiles()) {
    blocks_ = few_views_
                  ? DrawBlocksOfViews(set_, count, pace_.views_per_batch, options_.subject_share,
                                      options_.seed, iteration)
                  : DrawBlocks(set_, count, options_.subject_share, options_.seed, iteration);
    SortByPlace(blocks_);
    return {};
  }
  const size_t tiles = needs_tiles_ ? 1 : std::max<size_t>(1, count / kTileBlocks);
  DrawnTiles drawn =
      DrawTiles(set_, tiles, count / tiles, options_.subject_share, options_.seed, iteration);
  blocks_ = std::move(drawn.blocks);
  return drawn.shape;
}

// Gives each block's rays to a part of its pixels.
void BatchDrawer::RefineBlocks(uint64_t iteration, int samples) {
  TETREC_CHECK(!DrawsTiles(), "tiles are of one ray per pixel");
  Random random(options_.seed ^ 0xF1E5ull, iteration);
  const uint32_t columns = uint32_t(kRayBlockWidth / samples);
  const uint32_t rows = uint32_t(kRayBlockHeight / samples);
  for (RayBlock& block : blocks_) {
    block.x = (block.x + columns * random.Below(uint32_t(samples))) * uint32_t(samples);
    block.y = (block.y + rows * random.Below(uint32_t(samples))) * uint32_t(samples);
  }
}

}  // namespace tetrec
