// What the images ask of the mesh: the scores that a refinement takes.
#include "optimize/refine_scores.h"

#include "core/error.h"
#include "optimize/error_look.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

// Batches that no step draws.
constexpr uint64_t kFirstBatch = uint64_t{1} << 40;

struct GradientsOfRows {
  std::vector<double> color;     // rows: lengths of the sums of dL/dcolour
  std::vector<double> position;  // (V) GradientSums::absolute_position
};

GradientsOfRows SumGradients(TrainingRenderer& renderer, BatchDrawer& batches,
                             const OptimizeOptions& options, LossKind loss, GradientParts parts,
                             uint64_t iteration) {
  const FieldLayout layout = renderer.ReadState().layout;
  const size_t components = size_t(layout.Components());
  const double wanted = options.score_rays_per_tet * double(renderer.mesh().tets.size());
  GradientsOfRows result;
  const auto take = [&] {
    const GradientSums sums = renderer.TakeGradients();
    result.color.resize(sums.values.size() / components, 0.0);
    for (size_t row = 0; row < result.color.size(); ++row) {
      const double* color = sums.values.data() + row * components + kColorOffset;
      result.color[row] += std::hypot(color[0], color[1], color[2]);
    }
    result.position.resize(sums.absolute_position.size(), 0.0);
    for (size_t v = 0; v < result.position.size(); ++v) {
      result.position[v] += sums.absolute_position[v];
    }
  };
  renderer.TakeGradients();
  double rays = 0;
  for (uint64_t i = 0; rays < wanted; ++i) {
    TrainingBatch batch = batches.Draw(kFirstBatch + iteration + i);
    batch.loss = loss;
    batch.dssim_weight = 0;
    batch.update_rays = uint64_t(options.rays_per_step);
    renderer.Forward(batch);
    renderer.Backward(parts);
    rays += double(batch.rays());
    if ((i + 1) % kMostSummedBatches == 0 || rays >= wanted) take();
  }
  return result;
}

std::vector<float> ToFloat(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

}  // namespace

RefineScores LookAtScores(TrainingRenderer& renderer, const TrainingSet& set, BatchDrawer& batches,
                          const OptimizeOptions& options, uint64_t iteration) {
  RefineScores scores;
  switch (ScoreOf(options)) {
    case RefineScore::kAuto:
      break;
    case RefineScore::kResidual:
      scores.of_tets = LookAtErrors(renderer, set, batches, options, iteration);
      if (options.refine == RefineScheme::kInsert) {
        scores.visible_of_tets = LookAtLight(renderer, set, batches, options, iteration);
      }
      return scores;
    case RefineScore::kVariance:
      scores.of_tets = LookAtVariances(renderer, set, batches, options, iteration);
      return scores;
    case RefineScore::kColor: {
      const bool has_cells = options.storage == FieldStorage::kCell;
      std::vector<float>& of_rows = has_cells ? scores.of_tets : scores.of_vertices;
      of_rows = ToFloat(SumGradients(renderer, batches, options, LossKind::kSignedL2,
                                     GradientParts::kColorDensity, iteration)
                            .color);
      return scores;
    }
    case RefineScore::kPosition:
      scores.of_vertices = ToFloat(SumGradients(renderer, batches, options, options.loss.pixel,
                                                GradientParts::kColorDensityPosition, iteration)
                                       .position);
      return scores;
  }
  TETREC_CHECK(false, "no such score of refinement");
  return {};
}

}  // namespace tetrec
