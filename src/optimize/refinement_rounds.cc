// The rounds of refinement of a run, and the return to the best field.
#include "optimize/refinement_rounds.h"

#include "core/log.h"
#include "core/progress.h"
#include "core/timer.h"
#include "optimize/checkpoint.h"
#include "optimize/refine_scores.h"
#include "refine/refine.h"
#include "render/seen_colors.h"

#include <fmt/format.h>

namespace tetrec {

RefinementRounds::RefinementRounds(const OptimizeOptions& options, const GrowthPlan& plan,
                                   const RefinedParts& parts, std::filesystem::path best_file)
    : options_(options), plan_(plan), parts_(parts), best_file_(std::move(best_file)) {}

void RefinementRounds::Resume(const RoundsState& state) {
  state_ = state;
  last_iteration_ = parts_.steps.iteration();
}

bool RefinementRounds::IsDue(double progress) const {
  return int(state_.rounds) < plan_.rounds &&
         progress >= RoundProgress(options_.schedule, plan_, int(state_.rounds)) && IsTaught();
}

bool RefinementRounds::IsTaught() const {
  return options_.iterations > 0 ||
         parts_.steps.iteration() - last_iteration_ >= options_.schedule.min_round_steps;
}

void RefinementRounds::Advance() {
  if (parts_.pictures.learns_all() || IsWorthRefining()) RefineOnce();
}

// Judges the field that the last round led to.
bool RefinementRounds::IsWorthRefining() {
  const Judgement now = parts_.pictures.JudgeField();
  LogInfo(
      "judging pictures before round {}: {:.2f} dB, standard error {:.2f} (views {:.2f}, tiles "
      "{:.2f})",
      state_.rounds + 1, now.psnr, now.standard_error, now.views_psnr, now.tiles_psnr);
  const bool is_first = state_.rounds == 0;
  if (!is_first && !(now.psnr > state_.best_psnr - options_.schedule.judged_loss)) {
    ReturnToBest(now.psnr);
    return false;
  }
  if (is_first || now.psnr > state_.best_psnr) SaveBest(now.psnr);
  return true;
}

void RefinementRounds::SaveBest(double psnr) {
  state_.best_psnr = psnr;
  Checkpoint best;
  best.best_psnr = psnr;
  best.mesh = parts_.field.mesh();
  best.state = parts_.field.ReadState();
  WriteCheckpoint(best_file_, best);
}

// The mesh stays as it was then.
void RefinementRounds::ReturnToBest(double psnr) {
  Checkpoint best = ReadCheckpoint(best_file_);
  LogInfo(
      "round {} lost {:.2f} dB on the judging pictures: returns to {} vertices and refines no more",
      state_.rounds, state_.best_psnr - psnr, WithThousands(best.mesh.positions.size()));
  parts_.field.Put(std::move(best.mesh),
                   WithHarmonics(best.state, parts_.field.harmonics_degree()));
  state_.rounds = uint32_t(plan_.rounds);
}

void RefinementRounds::RefineOnce() {
  const Timer timer;
  const size_t vertices_before = parts_.field.mesh().positions.size();
  RefineScores scores = LookAtScores(parts_.renderer, parts_.pictures.set(), parts_.batches,
                                     options_, parts_.steps.iteration());
  const double look_seconds = timer.seconds();
  RefineOptions refine;
  refine.scheme = options_.refine;
  refine.diagonals = options_.prism_diagonals;
  refine.split_share = options_.split_share;
  refine.growth = RoundGrowth(plan_, int(state_.rounds), vertices_before);
  refine.max_vertices = plan_.max_vertices;
  refine.seed = options_.seed + state_.rounds;
  const FieldState before = parts_.field.ReadState();
  RefineResult result = Refine(parts_.field.TakeMesh(), before, std::move(scores), refine);
  parts_.field.Put(std::move(result.mesh), std::move(result.state));
  parts_.motion.Follow(result.of_vertices);
  ++state_.rounds;
  last_iteration_ = parts_.steps.iteration();
  const TetMesh& mesh = parts_.field.mesh();
  LogInfo(
      "round {}: {} -> {} vertices, {} tets: {} edges split, {} empty vertices dropped{}; errors "
      "{:.1f} s, mesh {:.1f} s",
      state_.rounds, WithThousands(vertices_before), WithThousands(mesh.positions.size()),
      WithThousands(mesh.tets.size()), WithThousands(result.split_edges),
      WithThousands(result.dropped_empty),
      result.refused > 0 ? fmt::format(", {} splits refused", WithThousands(result.refused)) : "",
      look_seconds, timer.seconds() - look_seconds);
}

}  // namespace tetrec
