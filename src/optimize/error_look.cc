// A look at the errors of a field: which tets the images blame.
#include "optimize/error_look.h"

#include "core/log.h"
#include "core/progress.h"
#include "core/random.h"
#include "render/ray_blocks.h"
#include "shared/gpu_types.glsl.h"

#include <algorithm>
#include <span>

namespace tetrec {

namespace {

constexpr size_t kBatch = 4096;  // blocks

// Draws as many of the blocks to learn from as it takes to judge `tets` tets, and returns them view
// by view.
std::vector<RayBlock> DrawJudgingBlocks(const TrainingSet& set, const OptimizeOptions& options,
                                        uint64_t tets, uint64_t iteration) {
  std::vector<RayBlock> blocks = LearnedBlocks(set);
  Random random(options.seed ^ 0x5C0ull, iteration);
  size_t wanted =
      std::min(blocks.size(), size_t(options.score_rays_per_tet * double(tets)) / kRaysPerBlock);
  if (options.renderer.deterministic && wanted > kMostScoredRays / kRaysPerBlock) {
    LogInfo("judges the tets by {} rays, not {}: fixed-point scores are for no more",
            WithThousands(kMostScoredRays), WithThousands(wanted * kRaysPerBlock));
    wanted = kMostScoredRays / kRaysPerBlock;
  }
  DrawInFront(std::span(blocks), wanted, random);
  blocks.resize(wanted);
  SortByPlace(blocks);
  return blocks;
}

// Calls add(batch) for batches of all blocks.
template <class Add>
void ForEachBatch(std::span<const RayBlock> blocks, const BatchDrawer& batches, uint64_t iteration,
                  const Add& add) {
  for (size_t first = 0, count = 0; first < blocks.size(); first += count) {
    TrainingBatch batch;
    count = batches.CountOfBatch(blocks.subspan(first), kBatch);
    batch.blocks = blocks.subspan(first, count);
    batch.background_srgb = batches.Background(iteration + first);
    add(batch);
  }
}

TetScores ScoresOf(TrainingRenderer& renderer, std::span<const RayBlock> blocks,
                   const BatchDrawer& batches, uint64_t iteration) {
  renderer.ClearScores();
  ForEachBatch(blocks, batches, iteration, [&](const TrainingBatch& batch) {
    renderer.AddScores(batch, ScoreKind::kSquaredResidual);
  });
  return renderer.ReadScores();
}

}  // namespace

TetScores LookAtTets(TrainingRenderer& renderer, const TrainingSet& set, const BatchDrawer& batches,
                     const OptimizeOptions& options, uint64_t iteration) {
  OptimizeOptions of_look = options;
  of_look.score_rays_per_tet = std::max(of_look.score_rays_per_tet, 1.0);
  const size_t tets = renderer.mesh().tets.size();
  return ScoresOf(renderer, DrawJudgingBlocks(set, of_look, tets, iteration), batches, iteration);
}

uint64_t CountEmpty(const std::vector<float>& light_of_tets) {
  return uint64_t(std::ranges::count(light_of_tets, 0.0f));
}

std::vector<float> LookAtVariances(TrainingRenderer& renderer, const TrainingSet& set,
                                   const BatchDrawer& batches, const OptimizeOptions& options,
                                   uint64_t iteration) {
  const size_t tets = renderer.mesh().tets.size();
  const std::vector<RayBlock> blocks = DrawJudgingBlocks(set, options, tets, iteration);
  std::vector<double> sums(tets, 0.0), squares(tets, 0.0);
  double views = 0;
  for (size_t first = 0, last = 0; first < blocks.size(); first = last, ++views) {
    while (last < blocks.size() && blocks[last].view == blocks[first].view) ++last;
    const std::vector<float> of_view =
        ScoresOf(renderer, std::span(blocks).subspan(first, last - first), batches,
                 iteration + first)
            .errors;
    for (size_t t = 0; t < tets; ++t) {
      sums[t] += of_view[t];
      squares[t] += double(of_view[t]) * of_view[t];
    }
  }
  std::vector<float> variances(tets, 0.0f);
  for (size_t t = 0; t < tets && views > 0; ++t) {
    const double mean = sums[t] / views;
    variances[t] = float(std::max(0.0, squares[t] / views - mean * mean));
  }
  return variances;
}

std::vector<EdgeSums> LookAtEdges(TrainingRenderer& renderer, const TrainingSet& set,
                                  const BatchDrawer& batches, const OptimizeOptions& options,
                                  uint64_t iteration, const MeshEdges& edges) {
  const std::vector<RayBlock> blocks =
      DrawJudgingBlocks(set, options, renderer.mesh().tets.size(), iteration);
  renderer.ClearEdgeSums(edges);
  ForEachBatch(blocks, batches, iteration,
               [&](const TrainingBatch& batch) { renderer.AddEdgeSums(batch); });
  return renderer.TakeEdgeSums();
}

}  // namespace tetrec
