// What the images ask of the mesh: the scores that a refinement takes.
#include "optimize/refine_scores.h"

#include "core/error.h"
#include "mesh/mesh_edges.h"
#include "optimize/edge_gains.h"
#include "optimize/error_look.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
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
    batch.update_rays = uint64_t(batches.rays_per_step());
    renderer.Forward(batch);
    renderer.Backward(parts);
    rays += double(batch.rays());
    if ((i + 1) % kMostSummedBatches == 0 || rays >= wanted) take();
  }
  return result;
}

// A tet's score is the gain of its longest edge, which insertion and bisection split (halving ranks
// all edges by their length and the scores of the tets around them); a vertex's
// score is the sum of the gains of all edges at it, which the prism scheme splits.
RefineScores ScoresByGain(const TetMesh& mesh, const MeshEdges& edges,
                          const std::vector<double>& gains) {
  RefineScores scores;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    const size_t longest = size_t(LongestEdge(mesh, mesh.tets[t]));
    scores.of_tets.push_back(float(gains[edges.of_tets[6 * t + longest]]));
  }
  scores.of_vertices.assign(mesh.positions.size(), 0.0f);
  for (size_t e = 0; e < gains.size(); ++e) {
    scores.of_vertices[edges.ends[e].x] += float(gains[e]);
    scores.of_vertices[edges.ends[e].y] += float(gains[e]);
  }
  return scores;
}

RefineScores LookAtGains(TrainingRenderer& renderer, const TrainingSet& set,
                         const BatchDrawer& batches, const OptimizeOptions& options,
                         uint64_t iteration) {
  const MeshEdges edges = EdgesOf(renderer.mesh());
  const std::vector<EdgeSums> sums = LookAtEdges(renderer, set, batches, options, iteration, edges);
  return ScoresByGain(renderer.mesh(), edges, GainsOfEdges(edges, renderer.ReadState(), sums));
}

std::vector<float> ToFloat(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

RefineScores ScoresOfKind(TrainingRenderer& renderer, const TrainingSet& set, BatchDrawer& batches,
                          const OptimizeOptions& options, uint64_t iteration) {
  RefineScores scores;
  switch (ScoreOf(options)) {
    case RefineScore::kAuto:
      break;
    case RefineScore::kResidual:
      scores.of_tets = LookAtTets(renderer, set, batches, options, iteration).errors;
      return scores;
    case RefineScore::kVariance:
      scores.of_tets = LookAtVariances(renderer, set, batches, options, iteration);
      return scores;
    case RefineScore::kGain:
      return LookAtGains(renderer, set, batches, options, iteration);
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

}  // namespace

RefineScores LookAtScores(TrainingRenderer& renderer, const TrainingSet& set, BatchDrawer& batches,
                          const OptimizeOptions& options, uint64_t iteration) {
  if (!DropsVertices(options.refine)) {
    return ScoresOfKind(renderer, set, batches, options, iteration);
  }
  TetScores of_tets = LookAtTets(renderer, set, batches, options, iteration);
  const bool by_error = ScoreOf(options) == RefineScore::kResidual;
  RefineScores scores =
      by_error ? RefineScores{} : ScoresOfKind(renderer, set, batches, options, iteration);
  scores.squared_error = std::accumulate(of_tets.errors.begin(), of_tets.errors.end(), 0.0);
  scores.visible_of_tets = std::move(of_tets.light);
  if (by_error) scores.of_tets = std::move(of_tets.errors);
  return scores;
}

}  // namespace tetrec
