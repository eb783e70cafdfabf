// Coarsening once the mesh has grown.
#include "optimize/coarsening.h"

#include "core/log.h"
#include "core/progress.h"
#include "optimize/checkpoint.h"
#include "optimize/refine_scores.h"
#include "refine/refine.h"

#include <cmath>
#include <utility>

namespace tetrec {
namespace {

// A trial that would keep more of the vertices is not worth its steps.
constexpr double kMostKept = 0.75;
// The progress of a run from which on none is held.
constexpr double kLastTrial = 0.8;

bool IsWanted(const OptimizeOptions& options) {
  const bool chooses_size = options.budget == BudgetChoice::kAuto && !options.schedule.rounds;
  const bool knows_need = options.refine == RefineScheme::kInsert &&
                          ScoreOf(options) == RefineScore::kResidual &&
                          options.storage == FieldStorage::kVertex;
  return chooses_size && knows_need && options.judging_pictures == JudgingPictures::kKept;
}

}  // namespace

Coarsening::Coarsening(const OptimizeOptions& options, const RefinedParts& parts,
                       RefinementRounds& rounds, std::filesystem::path finer_file)
    : options_(options),
      parts_(parts),
      rounds_(rounds),
      finer_file_(std::move(finer_file)),
      is_wanted_(IsWanted(options)) {}

bool Coarsening::IsDue(double progress) const {
  if (progress >= kLastTrial || IsOver() || !rounds_.IsOver() || parts_.pictures.learns_all())
    return false;
  const std::vector<GrowthStep>& steps = rounds_.state().steps;
  const uint64_t last = steps.empty() ? 0 : steps.back().iteration;
  return parts_.steps.iteration() >= last + kFewestTrialSteps;
}

void Coarsening::Advance(double seconds, double progress) {
  const uint64_t steps = TrialSteps(parts_.steps.iteration());
  if (state_.reference.empty()) {
    LookAtFinest(steps, progress);
    return;
  }
  Checkpoint finer;
  finer.mesh = parts_.field.mesh();
  finer.state = parts_.field.ReadState();
  WriteCheckpoint(finer_file_, finer);
  finer.mesh = {};
  const MotionState motion = parts_.motion.state();
  if (!DropLeastNeeded(finer.state)) {
    state_.ended = 1;
    TakeBack(motion);
    return;
  }
  finer = {};
  parts_.steps.Try(steps, kRatesOfTrials, progress);
  Decide(seconds, steps, motion);
}

// As long as each trial, so that they can be compared.
void Coarsening::LookAtFinest(uint64_t steps, double progress) {
  parts_.steps.Try(steps, kRatesOfTrials, progress);
  parts_.steps.CountTried(steps);
  state_.reference = parts_.pictures.JudgeField().views;
}

// Returns false if the mesh would get no coarser.
bool Coarsening::DropLeastNeeded(const FieldState& before) {
  const size_t tets = parts_.field.mesh().tets.size();
  RefineScores scores = LookAtScores(parts_.renderer, parts_.pictures.set(), parts_.batches,
                                     options_, parts_.steps.iteration());
  for (const float room : parts_.field.RoomOfVertices()) scores.is_kept.push_back(room <= 0.0f);
  RefineOptions coarsen;
  coarsen.growth = 0;
  coarsen.kept_share = state_.kept_share;
  coarsen.seed = options_.seed;
  RefineResult result = Refine(parts_.field.TakeMesh(), before, scores, coarsen);
  const bool is_coarser = result.mesh.tets.size() < tets;
  parts_.field.Put(std::move(result.mesh), std::move(result.state));
  parts_.motion.Follow(result.of_vertices);
  return is_coarser;
}

void Coarsening::Decide(double seconds, uint64_t steps, const MotionState& motion) {
  Judgement now = parts_.pictures.JudgeField();
  const JudgedGain gain = GainBetween(state_.reference, now.views);
  const bool stays =
      now.psnr >= options_.schedule.matched_psnr || gain.gain >= -gain.standard_error;
  GrowthStep step = StepOf(seconds, parts_.steps.iteration(), parts_.field.mesh());
  step.psnr = now.psnr;
  step.gain = gain.gain;
  step.gain_standard_error = gain.standard_error;
  step.decision = stays ? GrowthDecision::kCoarsen : GrowthDecision::kTooCoarse;
  rounds_.Record(step);
  LogInfo(
      "judging pictures with {} vertices, {} tets: {:.2f} dB; gain {:+.2f} dB, standard error "
      "{:.2f}: {}",
      WithThousands(step.vertices), WithThousands(step.tets), now.psnr, gain.gain,
      gain.standard_error, stays ? "the coarser mesh stays" : "the finer mesh stays");
  if (stays) {
    Keep(std::move(now), steps);
  } else {
    TakeBack(motion);
  }
}

void Coarsening::Keep(Judgement judgement, uint64_t steps) {
  parts_.steps.CountTried(steps);
  if (GainBetween(state_.reference, judgement.views).gain > 0) {
    state_.reference = std::move(judgement.views);
  }
  if (state_.has_failed == 0) state_.kept_share *= state_.kept_share;
}

void Coarsening::TakeBack(const MotionState& motion) {
  Checkpoint finer = ReadCheckpoint(finer_file_);
  parts_.field.Put(std::move(finer.mesh), std::move(finer.state));
  parts_.motion.Resume(motion);
  state_.has_failed = 1;
  state_.kept_share = std::sqrt(state_.kept_share);
  if (state_.kept_share > kMostKept) state_.ended = 1;
}

}  // namespace tetrec
