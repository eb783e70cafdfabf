// The views that a field is fitted to, and the choice of blocks of their pixels.
#include "optimize/training_set.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"
#include "image/image.h"
#include "render/target_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

bool ShowsSomething(const TargetImage& target, int x0, int y0, int margin) {
  const int x_end = std::min(target.width, x0 + kRayBlockWidth + margin);
  const int y_end = std::min(target.height, y0 + kRayBlockHeight + margin);
  for (int y = std::max(0, y0 - margin); y < y_end; ++y) {
    for (int x = std::max(0, x0 - margin); x < x_end; ++x) {
      if (target.rgba8[size_t(y) * target.width + x] >> 24 != 0) return true;
    }
  }
  return false;
}

// A random shift of less than `size` to either side.
int Shift(Random& random, int size) {
  return int(random.Below(uint32_t(2 * size - 1))) - (size - 1);
}

// Blocks to draw from: some of TrainingSet::blocks, and those of its subject_blocks among them.
struct BlockPool {
  AlignedBlocks::Range all;
  std::span<const uint32_t> subject;
};

BlockPool AllBlocks(const TrainingSet& set) { return {{0, set.blocks.size()}, set.subject_blocks}; }

BlockPool BlocksOfView(const TrainingSet& set, uint32_t view) {
  const AlignedBlocks::Range all = set.blocks.OfView(view);
  // Clang 14 cannot compile std::ranges::equal_range.
  return {all, std::span(std::ranges::lower_bound(set.subject_blocks, all.begin),
                         std::ranges::lower_bound(set.subject_blocks, all.end))};
}

RayBlock DrawBlock(const TrainingSet& set, const BlockPool& pool, double subject_share,
                   Random& random) {
  const bool subject = !pool.subject.empty() && (set.has_masks || random.Uniform() < subject_share);
  RayBlock block =
      set.blocks[subject ? pool.subject[random.Below(uint32_t(pool.subject.size()))]
                         : pool.all.begin + random.Below(uint32_t(pool.all.end - pool.all.begin))];
  // Offsets need not be aligned, but blocks stay inside the image.
  const TargetImage& target = set.targets[block.view];
  const int x = int(block.x) + Shift(random, kRayBlockWidth);
  const int y = int(block.y) + Shift(random, kRayBlockHeight);
  block.x = uint32_t(std::clamp(x, 0, target.width - kRayBlockWidth));
  block.y = uint32_t(std::clamp(y, 0, target.height - kRayBlockHeight));
  return block;
}

}  // namespace

RenderView MakeRenderView(const Scene& scene, int view) {
  return {scene.cameras[scene.views[view].camera], scene.views[view].cam_from_world};
}

TrainingSet LoadTrainingSet(const std::filesystem::path& scene_folder, const Scene& scene,
                            const std::vector<int>& views) {
  if (views.empty()) {
    throw DataError(fmt::format("{}: the scene has no training view", scene_folder.string()));
  }
  TrainingSet set;
  set.views.resize(views.size());
  set.targets.resize(views.size());
  ParallelFor(views.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const View& view = scene.views[views[i]];
      const Camera& camera = scene.cameras[view.camera];
      const Image image = ReadImage(scene_folder / view.image);
      if (image.width != camera.width || image.height != camera.height) {
        throw DataError(fmt::format("{}: the image has {}x{} pixels, its camera {}x{}",
                                    (scene_folder / view.image).string(), image.width, image.height,
                                    camera.width, camera.height));
      }
      if (image.width < kRayBlockWidth || image.height < kRayBlockHeight) {
        throw DataError(fmt::format("{}: an image of {}x{} pixels is too small to train on",
                                    (scene_folder / view.image).string(), image.width,
                                    image.height));
      }
      set.views[i] = MakeRenderView(scene, views[i]);
      set.targets[i] = TargetOf(image, scene.has_masks);
    }
  });
  for (const TargetImage& target : set.targets) set.pixels += target.rgba8.size();
  set.has_masks = scene.has_masks;
  ListBlocks(set, {});
  if (scene.has_masks && set.subject_blocks.empty()) {
    throw DataError(fmt::format("{}: the masks leave no pixel of any training view to train on",
                                scene_folder.string()));
  }
  return set;
}

void AlignedBlocks::Add(uint32_t view, int width, int height) {
  const size_t columns = size_t((width + kRayBlockWidth - 1) / kRayBlockWidth);
  const size_t rows = size_t((height + kRayBlockHeight - 1) / kRayBlockHeight);
  views_.push_back({size(), size() + columns * rows, view, uint32_t(columns)});
}

RayBlock AlignedBlocks::operator[](size_t index) const {
  const BlocksOfView& own = *std::ranges::upper_bound(views_, index, {}, &BlocksOfView::end);
  const uint32_t place = uint32_t(index - own.begin);
  return {own.view, place % own.columns * uint32_t(kRayBlockWidth),
          place / own.columns * uint32_t(kRayBlockHeight)};
}

AlignedBlocks::Range AlignedBlocks::OfView(uint32_t view) const {
  const auto own = std::ranges::lower_bound(views_, view, {}, &BlocksOfView::view);
  if (own == views_.end() || own->view != view) return {size(), size()};
  return {own->begin, own->end};
}

std::vector<RayBlock> AlignedBlocks::List() const {
  std::vector<RayBlock> blocks(size());
  for (size_t i = 0; i < blocks.size(); ++i) blocks[i] = (*this)[i];
  return blocks;
}

void ListBlocks(TrainingSet& set, std::span<const uint8_t> left_out) {
  // Includes a margin around the subject, where floaters would hide.
  constexpr int kMarginPx = 4;
  set.blocks = {};
  set.subject_blocks.clear();
  for (uint32_t v = 0; v < set.views.size(); ++v) {
    if (!left_out.empty() && left_out[v]) continue;
    const TargetImage& target = set.targets[v];
    set.blocks.Add(v, target.width, target.height);
    const AlignedBlocks::Range own = set.blocks.OfView(v);
    for (size_t i = own.begin; i < own.end; ++i) {
      const RayBlock block = set.blocks[i];
      if (ShowsSomething(target, int(block.x), int(block.y), kMarginPx)) {
        set.subject_blocks.push_back(uint32_t(i));
      }
    }
  }
}

uint64_t SubjectPixels(const TrainingSet& set) {
  if (set.subject_blocks.empty()) return set.pixels;
  // Blocks may reach beyond their images.
  return std::min<uint64_t>(set.subject_blocks.size() * kRaysPerBlock, set.pixels);
}

std::vector<RayBlock> LearnedBlocks(const TrainingSet& set) {
  if (!set.has_masks) return set.blocks.List();
  std::vector<RayBlock> blocks;
  for (const uint32_t i : set.subject_blocks) blocks.push_back(set.blocks[i]);
  return blocks;
}

uint64_t LearnedPixels(const TrainingSet& set) {
  return set.has_masks ? SubjectPixels(set) : set.pixels;
}

std::vector<RayBlock> DrawBlocks(const TrainingSet& set, size_t count, double subject_share,
                                 uint64_t seed, uint64_t iteration) {
  Random random(seed, iteration);
  const BlockPool all = AllBlocks(set);
  std::vector<RayBlock> blocks(count);
  for (RayBlock& block : blocks) block = DrawBlock(set, all, subject_share, random);
  return blocks;
}

std::vector<RayBlock> DrawBlocksOfViews(const TrainingSet& set, size_t count, size_t views,
                                        double subject_share, uint64_t seed, uint64_t iteration) {
  Random random(seed, iteration);
  std::vector<BlockPool> pools;
  for (size_t i = 0; i < views; ++i) {
    pools.push_back(BlocksOfView(set, DrawBlock(set, AllBlocks(set), subject_share, random).view));
  }
  std::vector<RayBlock> blocks(count);
  for (size_t i = 0; i < count; ++i) {
    blocks[i] = DrawBlock(set, pools[i * views / count], subject_share, random);
  }
  return blocks;
}

DrawnTiles DrawTiles(const TrainingSet& set, size_t tiles, size_t count, double subject_share,
                     uint64_t seed, uint64_t iteration) {
  const std::vector<RayBlock> centers = DrawBlocks(set, tiles, subject_share, seed, iteration);
  int width = set.targets[centers[0].view].width, height = set.targets[centers[0].view].height;
  if (tiles > 1) {
    for (const TargetImage& target : set.targets) {
      width = std::min(width, target.width);
      height = std::min(height, target.height);
    }
  }
  // About square in pixels, and of whole blocks inside the image.
  const double side_px = std::sqrt(double(count * kRaysPerBlock));
  const int columns =
      std::clamp(int(std::lround(side_px / kRayBlockWidth)), 1, width / kRayBlockWidth);
  const int rows = std::clamp(int(count) / columns, 1, height / kRayBlockHeight);
  DrawnTiles drawn{{}, {uint32_t(columns), uint32_t(rows)}};
  for (const RayBlock& center : centers) {
    const TargetImage& target = set.targets[center.view];
    const int left = std::clamp(int(center.x) - columns / 2 * kRayBlockWidth, 0,
                                target.width - columns * kRayBlockWidth);
    const int top = std::clamp(int(center.y) - rows / 2 * kRayBlockHeight, 0,
                               target.height - rows * kRayBlockHeight);
    for (int row = 0; row < rows; ++row) {
      for (int column = 0; column < columns; ++column) {
        drawn.blocks.push_back({center.view, uint32_t(left + column * kRayBlockWidth),
                                uint32_t(top + row * kRayBlockHeight)});
      }
    }
  }
  return drawn;
}

}  // namespace tetrec
