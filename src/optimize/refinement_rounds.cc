// The rounds of refinement of a run, and the return to the best field.
#include "optimize/refinement_rounds.h"

#include "core/log.h"
#include "core/process_memory.h"
#include "core/progress.h"
#include "core/timer.h"
#include "optimize/checkpoint.h"
#include "optimize/error_look.h"
#include "optimize/field_on_disk.h"
#include "optimize/refine_scores.h"
#include "refine/refine.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace tetrec {

namespace {

// What the judging pictures may gain by a few steps at low rates [dB].
constexpr double kMostNoise = 5;

// A trial of a finer mesh late in a run takes this part of the steps so far, because what a step
// teaches falls with the steps; but at most 2,000, because on a GPU steps are many.
constexpr uint64_t kStepsPerTriedStep = 8, kMostStepsOfTrial = 2000;

// Late rounds refine the mesh in place. By then, vertices have moved far from a Delaunay mesh, so
// that a new triangulation changes tets everywhere: the demo's training pictures lost 4.3 dB and
// needed a minute of five to regain them.
RefineScheme SchemeOf(const PlannedRound& round, RefineScheme chosen) {
  return round.is_late && chosen == RefineScheme::kInsert ? RefineScheme::kHalve : chosen;
}

}  // namespace

GrowthStep StepOf(double seconds, uint64_t iteration, const TetMesh& mesh) {
  return {.iteration = iteration,
          .seconds = seconds,
          .vertices = mesh.positions.size(),
          .tets = mesh.tets.size(),
          .peak_rss_bytes = PeakRssBytes(),
          .degenerate_tets = CountDegenerateTets(mesh)};
}

RefinementRounds::RefinementRounds(const OptimizeOptions& options, std::vector<PlannedRound> plan,
                                   const RefinedParts& parts, RoundsFiles files, uint64_t max_tets)
    : options_(options),
      plan_(std::move(plan)),
      parts_(parts),
      files_(std::move(files)),
      max_tets_(max_tets) {}

void RefinementRounds::Resume(RoundsState state) {
  state_ = std::move(state);
  last_iteration_ = parts_.steps.iteration();
}

bool RefinementRounds::IsDue(double growth) const {
  return !IsOver() && growth >= plan_[state_.rounds].due && IsTaught();
}

bool RefinementRounds::IsTaught() const {
  return options_.iterations > 0 || options_.time_limit_s <= 0 || HasSettled() ||
         parts_.steps.iteration() - last_iteration_ >= options_.schedule.min_round_steps;
}

void RefinementRounds::Advance(double seconds, const RunMoment& moment) {
  const RoundsState before = state_;
  const uint64_t last_iteration = last_iteration_;
  GrowthStep step = StepOf(seconds, parts_.steps.iteration(), parts_.field.mesh());
  if (ComesTooLate(moment.progress)) return EndForLackOfTime(step);
  if (!parts_.pictures.learns_all()) {
    const Judgement now = parts_.pictures.JudgeField();
    if (MustSettle(now)) return Settle();
    if (!IsWorthRefining(now, step)) {
      state_.steps.push_back(step);
      return;
    }
  }
  state_.steps.push_back(step);
  if (!NeedsTrial()) {
    RefineOnce();
  } else if (!TryRefining(seconds, moment)) {
    state_ = before;
    last_iteration_ = last_iteration;
  }
}

// Judges the field that the last round led to.
bool RefinementRounds::IsWorthRefining(const Judgement& now, GrowthStep& step) {
  const JudgedGain gain = GainBetween(state_.last_views, now.views);
  step.psnr = now.psnr;
  step.gain = gain.gain;
  step.gain_standard_error = gain.standard_error;
  step.decision = Decide(now, gain);
  LogInfo(
      "judging pictures before round {}: {:.2f} dB, standard error {:.2f} (views {:.2f}, tiles "
      "{:.2f}); gain {:+.2f} dB, standard error {:.2f}",
      state_.rounds + 1, now.psnr, now.standard_error, now.views_psnr, now.tiles_psnr, gain.gain,
      gain.standard_error);
  if (step.decision == GrowthDecision::kReturn) ReturnToBest(now.psnr);
  if (step.decision == GrowthDecision::kFineEnough) {
    LogInfo("the mesh is fine enough: rounds gain no more than the standard error");
  }
  if (step.decision == GrowthDecision::kMatched) {
    LogInfo("the mesh is fine enough: the judging pictures are matched");
  }
  state_.ended = step.decision != GrowthDecision::kRefine;
  if (state_.ended != 0) return false;
  if (state_.rounds == 0 || now.psnr > state_.best_psnr) SaveBest(now.psnr);
  state_.last_views = now.views;
  return true;
}

// True if the noise of high learning rates may hide that the pictures are matched.
bool RefinementRounds::MustSettle(const Judgement& now) const {
  // Once a judgement has settled, later ones must, too: otherwise, noise would look like a loss.
  const double best = std::max(now.psnr, state_.best_psnr);
  const bool may_be_matched = best >= options_.schedule.matched_psnr - kMostNoise;
  return !HasSettled() && may_be_matched && !AsksForAll() && !IsMatched(now, options_.schedule);
}

bool RefinementRounds::HasSettled() const {
  return state_.settled > 0 && state_.settled == parts_.steps.iteration();
}

// Ends where a motion would, so that no further step comes before a round that is a trial.
void RefinementRounds::Settle() {
  const uint64_t iteration = parts_.steps.iteration();
  const uint64_t steps = parts_.motion.StepsToAMotion(iteration, TrialSteps(iteration));
  parts_.motion.DropSums();
  parts_.steps.Try(steps, kRatesOfTrials);
  parts_.steps.CountTried(steps);
  state_.settled = parts_.steps.iteration();
}

bool RefinementRounds::AsksForAll() const {
  return options_.budget == BudgetChoice::kFull || options_.schedule.rounds;
}

bool RefinementRounds::ComesTooLate(double progress) const {
  const ScheduleOptions& schedule = options_.schedule;
  return !AsksForAll() && progress >= std::max(schedule.last_round, schedule.last_judging);
}

void RefinementRounds::EndForLackOfTime(GrowthStep step) {
  step.decision = GrowthDecision::kTooLate;
  state_.steps.push_back(step);
  state_.ended = 1;
  LogInfo("{} of {} rounds: too little of the run is left to learn a finer mesh", state_.rounds,
          plan_.size());
}

// Early rounds gain far more than the noise of high rates, and late ones less than what learning
// gains meanwhile.
bool RefinementRounds::NeedsTrial() const {
  return plan_[state_.rounds].is_late && !parts_.pictures.learns_all() && !AsksForAll();
}

GrowthDecision RefinementRounds::Decide(const Judgement& now, const JudgedGain& gain) const {
  const bool is_matched = !AsksForAll() && IsMatched(now, options_.schedule);
  if (state_.rounds == 0) return is_matched ? GrowthDecision::kMatched : GrowthDecision::kRefine;
  // High learning rates make noise, so that a loss within the standard error shows nothing.
  const double least_loss = std::max(options_.schedule.judged_loss, gain.standard_error);
  if (!(now.psnr > state_.best_psnr - least_loss)) return GrowthDecision::kReturn;
  if (AsksForAll()) return GrowthDecision::kRefine;
  if (is_matched) return GrowthDecision::kMatched;
  // One early round may gain nothing by the noise of high learning rates; two in a row do not.
  const bool must_gain = plan_[state_.rounds].is_late || !LastRoundGained();
  return must_gain && !(gain.gain > gain.standard_error) ? GrowthDecision::kFineEnough
                                                         : GrowthDecision::kRefine;
}

// True for the first judgement, too, which has none before it to be compared with.
bool RefinementRounds::LastRoundGained() const {
  if (state_.steps.size() < 2 || !(state_.steps.end()[-2].psnr > 0)) return true;
  return state_.steps.back().gain > state_.steps.back().gain_standard_error;
}

void RefinementRounds::JudgeAnew(const Judgement& now) {
  if (IsOver() || state_.rounds == 0) return;
  SaveBest(now.psnr);
  state_.last_views = now.views;
}

void RefinementRounds::SaveBest(double psnr) {
  state_.best_psnr = psnr;
  SaveField(files_.best, parts_.field);
}

// The mesh stays as it was then.
void RefinementRounds::ReturnToBest(double psnr) {
  RestoreField(files_.best, parts_.field);
  LogInfo(
      "round {} lost {:.2f} dB on the judging pictures: returns to {} vertices and refines no more",
      state_.rounds, state_.best_psnr - psnr, WithThousands(parts_.field.mesh().positions.size()));
}

// None if no refined mesh was found that the budget allows; the field is then as before. The number
// of tets is known only once the points are triangulated, so a few numbers of vertices are tried.
// Meanwhile the mesh waits on disk: memory is scarcest during a triangulation.
std::optional<RefineResult> RefinementRounds::RefineWithinBudget(const FieldState& before,
                                                                 const RefineScores& scores,
                                                                 RefineOptions refine) {
  if (max_tets_ == kNoBudget) return Refine(parts_.field.TakeMesh(), before, scores, refine);
  constexpr int kMostTries = 4;
  constexpr double kMargin = 0.99;
  const WaitingField unrefined(files_.unrefined, parts_.field, parts_.motion);
  TetMesh mesh = parts_.field.TakeMesh();
  uint64_t tets = mesh.tets.size(), vertices = mesh.positions.size();
  for (int i = 0; i < kMostTries; ++i) {
    const double affordable = double(max_tets_) / double(tets) * double(vertices);
    const double allowed = i == 0 ? affordable : kMargin * affordable;
    refine.max_vertices = std::min(refine.max_vertices, uint64_t(allowed));
    RefineResult result = Refine(std::move(mesh), before, scores, refine);
    tets = result.mesh.tets.size();
    vertices = result.mesh.positions.size();
    if (tets <= max_tets_) return result;
    result = {};
    if (i + 1 < kMostTries) mesh = ReadCheckpoint(files_.unrefined).mesh;
  }
  unrefined.PutBack(parts_.field, parts_.motion);
  return {};
}

void RefinementRounds::RefineOnce() {
  const Timer timer;
  const size_t vertices_before = parts_.field.mesh().positions.size();
  RefineScores scores = LookAtScores(parts_.renderer, parts_.pictures.set(), parts_.batches,
                                     options_, parts_.steps.iteration());
  const double look_seconds = timer.seconds();
  if (!scores.visible_of_tets.empty()) {
    state_.steps.back().empty_tets = CountEmpty(scores.visible_of_tets);
  }
  for (const float room : parts_.field.RoomOfVertices()) scores.is_kept.push_back(room <= 0.0f);
  RefineOptions refine;
  const PlannedRound& round = plan_[state_.rounds];
  refine.scheme = SchemeOf(round, options_.refine);
  refine.diagonals = options_.prism_diagonals;
  refine.split_share = options_.split_share;
  refine.growth = RoundGrowth(round, vertices_before);
  refine.max_vertices = round.vertices;
  refine.seed = options_.seed + state_.rounds;
  const FieldState before = parts_.field.ReadState();
  std::optional<RefineResult> refined = RefineWithinBudget(before, scores, refine);
  if (!refined) {
    state_.steps.back().decision = GrowthDecision::kBudget;
    state_.ended = 1;
    LogInfo("the mesh stays as it is: any refined one would exceed the budget of {} tets",
            WithThousands(max_tets_));
    return;
  }
  RefineResult& result = *refined;
  parts_.field.Put(std::move(result.mesh), std::move(result.state));
  parts_.motion.Follow(result.of_vertices);
  ++state_.rounds;
  last_iteration_ = parts_.steps.iteration();
  const TetMesh& mesh = parts_.field.mesh();
  LogInfo(
      "round {}: {} -> {} vertices, {} tets: {} edges split, {} empty and {} flat vertices "
      "dropped, {} put back and {} added to keep clear space clear{}; errors "
      "{:.2f} s, mesh {:.2f} s",
      state_.rounds, WithThousands(vertices_before), WithThousands(mesh.positions.size()),
      WithThousands(mesh.tets.size()), WithThousands(result.split_edges),
      WithThousands(result.dropped_empty), WithThousands(result.dropped_flat),
      WithThousands(result.put_back), WithThousands(result.patches),
      result.refused > 0 ? fmt::format(", {} splits refused", WithThousands(result.refused)) : "",
      look_seconds, timer.seconds() - look_seconds);
}

// Returns false if the run is asked to stop meanwhile. The field is then as before.
bool RefinementRounds::TryRefining(double seconds, const RunMoment& moment) {
  const uint64_t iteration = parts_.steps.iteration(), rays = parts_.steps.rays();
  const uint64_t steps = StepsOfTrial();
  parts_.motion.DropSums();
  const WaitingField unrefined(files_.coarser, parts_.field, parts_.motion);
  RefineOnce();
  if (state_.ended != 0) return true;
  const GrowthStep finer_step = StepOf(seconds, iteration, parts_.field.mesh());
  const std::optional<Judgement> finer = Learn(iteration, steps, moment);
  std::optional<WaitingField> refined;
  if (finer) refined.emplace(files_.finer, parts_.field, parts_.motion);
  unrefined.PutBack(parts_.field, parts_.motion);
  const std::optional<Judgement> coarser =
      finer ? Learn(iteration, steps, moment) : std::optional<Judgement>();
  if (!coarser) {
    if (finer) unrefined.PutBack(parts_.field, parts_.motion);
    parts_.steps.Resume(iteration, rays);
    return false;
  }
  const JudgedGain gain = GainBetween(coarser->views, finer->views);
  const bool pays = gain.gain > gain.standard_error;
  LogInfo(
      "judging pictures after {} steps: {:.2f} dB with {} vertices, {:.2f} dB with {}; gain "
      "{:+.2f} dB, standard error {:.2f}: {}",
      steps, finer->psnr, WithThousands(finer_step.vertices), coarser->psnr,
      WithThousands(parts_.field.mesh().positions.size()), gain.gain, gain.standard_error,
      pays ? "the finer mesh stays" : "the mesh is fine enough");
  if (pays) {
    refined->PutBack(parts_.field, parts_.motion);
  } else {
    StayCoarser(finer_step, *finer, gain);
  }
  return true;
}

// A trial ends with a motion, because gradients that wait for one are lost when a run is stopped.
uint64_t RefinementRounds::StepsOfTrial() const {
  const uint64_t iteration = parts_.steps.iteration();
  return parts_.motion.StepsToAMotion(
      iteration, std::clamp(iteration / kStepsPerTriedStep, kMostTrialSteps, kMostStepsOfTrial));
}

// Takes steps from `from` on, at last by low rates, and judges. None if the run is asked to stop
// meanwhile.
std::optional<Judgement> RefinementRounds::Learn(uint64_t from, uint64_t steps,
                                                 const RunMoment& moment) {
  parts_.steps.Resume(from, parts_.steps.rays());
  const uint64_t settling = steps / 4;
  if (!LearnPart(steps - settling, moment, moment)) return {};
  if (!LearnPart(settling, kRatesOfTrials, moment)) return {};
  return parts_.pictures.JudgeField();
}

// Returns false if the run is asked to stop meanwhile.
bool RefinementRounds::LearnPart(uint64_t steps, const RunMoment& as_at, const RunMoment& moment) {
  if (!parts_.steps.TryUnlessStopped(steps, as_at, moment)) return false;
  parts_.steps.CountTried(steps);
  return true;
}

void RefinementRounds::StayCoarser(GrowthStep finer, const Judgement& judgement,
                                   const JudgedGain& gain) {
  finer.psnr = judgement.psnr;
  finer.gain = gain.gain;
  finer.gain_standard_error = gain.standard_error;
  finer.decision = GrowthDecision::kTooFine;
  state_.steps.push_back(finer);
  --state_.rounds;
  state_.ended = 1;
}

}  // namespace tetrec
