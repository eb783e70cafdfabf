// A look at the errors of a field: which tets the images blame.
#include "optimize/error_look.h"

#include "core/log.h"
#include "core/progress.h"
#include "core/random.h"
#include "shared/gpu_types.glsl.h"

#include <algorithm>
#include <span>

namespace tetrec {

namespace {

constexpr size_t kBatch = 4096;  // blocks

// How many of the blocks from `first` on make a batch of no more than kMostViewsOfBatch views.
size_t CountOfFewViews(std::span<const RayBlock> blocks, size_t first) {
  size_t count = 0, views = 0;
  while (count < kBatch && first + count < blocks.size()) {
    const size_t at = first + count;
    views += count == 0 || blocks[at].view != blocks[at - 1].view;
    if (views > kMostViewsOfBatch) break;
    ++count;
  }
  return count;
}

}  // namespace

std::vector<float> LookAtErrors(TrainingRenderer& renderer, const TrainingSet& set,
                                const BatchDrawer& batches, const OptimizeOptions& options,
                                uint64_t tets, uint64_t iteration) {
  std::vector<RayBlock> blocks = set.blocks;
  Random random(options.seed ^ 0x5C0ull, iteration);
  size_t wanted =
      std::min(blocks.size(), size_t(options.score_rays_per_tet * double(tets)) / kRaysPerBlock);
  if (options.renderer.deterministic && wanted > kMostScoredRays / kRaysPerBlock) {
    LogInfo("judges the tets by {} rays, not {}: fixed-point scores are for no more",
            WithThousands(kMostScoredRays), WithThousands(wanted * kRaysPerBlock));
    wanted = kMostScoredRays / kRaysPerBlock;
  }
  for (size_t i = 0; i < wanted; ++i) {
    std::swap(blocks[i], blocks[i + random.Below(uint32_t(blocks.size() - i))]);
  }
  blocks.resize(wanted);
  if (batches.few_views()) std::ranges::stable_sort(blocks, {}, &RayBlock::view);
  renderer.ClearScores();
  for (size_t first = 0, count = 0; first < wanted; first += count) {
    TrainingBatch batch;
    count = batches.few_views() ? CountOfFewViews(blocks, first) : std::min(kBatch, wanted - first);
    batch.blocks = std::span(blocks).subspan(first, count);
    batch.background_srgb = batches.Background(iteration + first);
    renderer.AddScores(batch, ScoreKind::kSquaredResidual);
  }
  return renderer.ReadScores();
}

}  // namespace tetrec
