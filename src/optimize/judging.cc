// The judging pictures: parts of the training pictures that are kept from gradients and refinement.
#include "optimize/judging.h"

#include "core/random.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace tetrec {
namespace {

constexpr uint32_t kTile = 16;  // [px] a side; whole blocks
constexpr uint64_t kSampleSeed = 0x5A3Bull;

// True if a tile of a whole view judges: every second one does, as on a chessboard.
bool IsJudgingSquare(uint32_t x, uint32_t y) { return (x / kTile + y / kTile) % 2 == 0; }

// Whether the tile that contains a pixel judges.
bool IsJudgingTile(uint64_t seed, uint32_t view, uint32_t x, uint32_t y) {
  const uint64_t tile = (uint64_t{view} << 40) ^ (uint64_t{y / kTile} << 20) ^ (x / kTile);
  return Random(seed ^ 0x7D6Eull, tile).Below(kTilesPerJudge) == 0;
}

void HideBlock(const RayBlock& block, TargetImage& target) {
  const int x_end = std::min(target.width, int(block.x) + kRayBlockWidth);
  const int y_end = std::min(target.height, int(block.y) + kRayBlockHeight);
  for (int y = int(block.y); y < y_end; ++y) {
    for (int x = int(block.x); x < x_end; ++x) {
      target.rgba8[size_t(y) * target.width + x] = kNotJudgedTarget;
    }
  }
}

// The blocks of rays through the pixels of `blocks`, samples x samples per pixel.
std::vector<RayBlock> BlocksOfRays(std::span<const RayBlock> blocks, int samples) {
  std::vector<RayBlock> rays;
  for (const RayBlock& block : blocks) {
    for (int i = 0; i < samples * samples; ++i) {
      RayBlock part = block;
      part.x = block.x * uint32_t(samples) + uint32_t(i % samples * kRayBlockWidth);
      part.y = block.y * uint32_t(samples) + uint32_t(i / samples * kRayBlockHeight);
      rays.push_back(part);
    }
  }
  return rays;
}

// Every n-th value, and at least one, so that each view judges. Of blocks, an odd n visits all
// columns of a tile, which is four blocks wide.
template <class T>
std::vector<T> EveryNth(std::span<const T> values, size_t n) {
  std::vector<T> some;
  for (size_t i = std::min(n, values.size()) / 2; i < values.size(); i += n) {
    some.push_back(values[i]);
  }
  return some;
}

// The pixels of a block that masks do not exclude.
uint8_t CountPixels(const RayBlock& block, const TargetImage& target) {
  const int x_end = std::min(target.width, int(block.x) + kRayBlockWidth);
  const int y_end = std::min(target.height, int(block.y) + kRayBlockHeight);
  uint8_t pixels = 0;
  for (int y = int(block.y); y < y_end; ++y) {
    for (int x = int(block.x); x < x_end; ++x) {
      pixels += target.rgba8[size_t(y) * size_t(target.width) + size_t(x)] != kNotJudgedTarget;
    }
  }
  return pixels;
}

// The sum of the squared errors of blocks of one view, which are rendered in batches of bounded
// size.
double SquaresOf(TrainingRenderer& renderer, std::span<const RayBlock> blocks,
                 const glm::vec3& background_srgb, int samples) {
  constexpr size_t kBlocksOfBatch = 8192;
  double sum = 0;
  for (size_t first = 0; first < blocks.size(); first += kBlocksOfBatch) {
    const std::vector<RayBlock> rays_of_part = BlocksOfRays(
        blocks.subspan(first, std::min(kBlocksOfBatch, blocks.size() - first)), samples);
    TrainingBatch batch;
    batch.blocks = rays_of_part;
    batch.samples = samples;
    batch.background_srgb = background_srgb;
    sum += renderer.Forward(batch).squared_error * double(batch.rays());
  }
  return sum;
}

// The standard error of the ratio of sums, over the views, to first order; in decibels.
double StandardError(std::span<const ErrorSum> views, const ErrorSum& all) {
  if (views.size() < 2 || all.squares <= 0) return 0;
  const double mean = all.squares / all.rays;
  double squares = 0;
  for (const ErrorSum& view : views) {
    const double deviation = view.squares - mean * view.rays;
    squares += deviation * deviation;
  }
  const double count = double(views.size());
  const double error = std::sqrt(squares * count / (count - 1)) / all.rays;
  return 10 / std::log(10.0) * error / mean;
}

}  // namespace

JudgingSet ChooseJudgingSet(const TrainingSet& set, uint64_t seed) {
  JudgingSet judging;
  judging.is_whole.assign(set.views.size(), 0);
  if (set.views.size() >= kLeastViewsToJudge) {
    for (size_t view = kViewsPerJudge / 2; view < set.views.size(); view += kViewsPerJudge) {
      judging.is_whole[view] = 1;
    }
  }
  for (const RayBlock& block : set.blocks.List()) {
    const uint8_t pixels = CountPixels(block, set.targets[block.view]);
    if (pixels == 0) continue;
    const bool is_of_whole = judging.is_whole[block.view] != 0;
    if (is_of_whole ? IsJudgingSquare(block.x, block.y)
                    : IsJudgingTile(seed, block.view, block.x, block.y)) {
      judging.blocks.push_back(block);
      judging.pixels.push_back(pixels);
    } else if (is_of_whole) {
      judging.spare_blocks.push_back(block);
    }
  }
  return judging;
}

JudgingSet SampleViews(const TrainingSet& set, size_t blocks_per_view) {
  JudgingSet sample;
  sample.is_whole.assign(set.views.size(), 0);
  for (uint32_t view = 0; view < set.views.size(); ++view) {
    const TargetImage& target = set.targets[view];
    AlignedBlocks aligned;
    aligned.Add(view, target.width, target.height);
    std::vector<RayBlock> blocks = aligned.List();
    std::erase_if(blocks, [&](const RayBlock& block) { return CountPixels(block, target) == 0; });
    const size_t count = std::min(blocks.size(), blocks_per_view);
    Random random(kSampleSeed, view);
    for (size_t i = 0; i < count; ++i) {
      const size_t first = blocks.size() * i / count, end = blocks.size() * (i + 1) / count;
      const RayBlock& block = blocks[first + random.Below(uint32_t(end - first))];
      sample.blocks.push_back(block);
      sample.pixels.push_back(CountPixels(block, target));
    }
  }
  return sample;
}

JudgingSet Without(const JudgingSet& judging, std::span<const uint8_t> left_out) {
  if (left_out.empty()) return judging;
  JudgingSet rest;
  rest.is_whole = judging.is_whole;
  for (size_t i = 0; i < judging.blocks.size(); ++i) {
    if (left_out[judging.blocks[i].view]) continue;
    rest.blocks.push_back(judging.blocks[i]);
    rest.pixels.push_back(judging.pixels[i]);
  }
  std::ranges::copy_if(judging.spare_blocks, std::back_inserter(rest.spare_blocks),
                       [&](const RayBlock& block) { return !left_out[block.view]; });
  return rest;
}

std::vector<TargetImage> TargetsToLearn(const TrainingSet& set, const JudgingSet& judging) {
  std::vector<TargetImage> targets = set.targets;
  for (const RayBlock& block : judging.blocks) HideBlock(block, targets[block.view]);
  return targets;
}

Judgement Judge(TrainingRenderer& renderer, const JudgingSet& judging,
                const glm::vec3& background_srgb, int samples, size_t most_pixels) {
  std::vector<ErrorSum> views;
  ErrorSum all, whole, tiles;
  const std::span<const RayBlock> blocks = judging.blocks;
  const std::span<const uint8_t> counts = judging.pixels;
  const size_t pixels = blocks.size() * kRaysPerBlock;
  const size_t n = ((std::max<size_t>(pixels, 1) - 1) / most_pixels + 1) | 1;
  for (size_t begin = 0, end = 0; begin < blocks.size(); begin = end) {
    while (end < blocks.size() && blocks[end].view == blocks[begin].view) ++end;
    const std::vector<RayBlock> judged = EveryNth(blocks.subspan(begin, end - begin), n);
    double pixels_of_view = 0;
    for (const uint8_t count : EveryNth(counts.subspan(begin, end - begin), n)) {
      pixels_of_view += count;
    }
    const ErrorSum sum{SquaresOf(renderer, judged, background_srgb, samples),
                       pixels_of_view * samples * samples};
    views.push_back(sum);
    all.Add(sum);
    (judging.is_whole[blocks[begin].view] ? whole : tiles).Add(sum);
  }
  const double standard_error = StandardError(views, all);
  return {all.Psnr(), standard_error, whole.Psnr(), tiles.Psnr(), std::move(views)};
}

double ErrorSum::Psnr() const {
  return rays > 0 ? -10 * std::log10(std::max(squares / rays, 1e-12)) : 0;
}

JudgedGain GainBetween(std::span<const ErrorSum> before, std::span<const ErrorSum> after) {
  if (before.empty() || before.size() != after.size()) return {};
  ErrorSum all_before, all_after;
  for (const ErrorSum& view : before) all_before.Add(view);
  for (const ErrorSum& view : after) all_after.Add(view);
  // To first order, log(after / before) deviates by the sum over the views of these terms.
  const double mean_before = all_before.squares / all_before.rays;
  const double mean_after = all_after.squares / all_after.rays;
  if (!(mean_before > 0 && mean_after > 0)) return {all_after.Psnr() - all_before.Psnr(), 0};
  double squares = 0;
  for (size_t view = 0; view < before.size(); ++view) {
    const double deviation =
        (after[view].squares / mean_after - after[view].rays) / all_after.rays -
        (before[view].squares / mean_before - before[view].rays) / all_before.rays;
    squares += deviation * deviation;
  }
  const double count = double(before.size());
  const double error = count > 1 ? std::sqrt(squares * count / (count - 1)) : 0.0;
  return {all_after.Psnr() - all_before.Psnr(), 10 / std::log(10.0) * error};
}

}  // namespace tetrec
