// A look at the errors of a field: which tets the images blame.
#include "optimize/error_look.h"

#include "core/log.h"
#include "core/progress.h"
#include "core/random.h"
#include "shared/gpu_types.glsl.h"

#include <algorithm>
#include <span>

namespace tetrec {

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
  renderer.ClearScores();
  constexpr size_t kBatch = 4096;
  for (size_t first = 0; first < wanted; first += kBatch) {
    TrainingBatch batch;
    batch.blocks = std::span(blocks).subspan(first, std::min(kBatch, wanted - first));
    batch.background_srgb = batches.Background(iteration + first);
    renderer.AddScores(batch, ScoreKind::kSquaredResidual);
  }
  return renderer.ReadScores();
}

}  // namespace tetrec
