// Coarsening once the mesh has grown.
#include "optimize/coarsening.h"

#include "core/log.h"
#include "core/progress.h"
#include "optimize/field_on_disk.h"
#include "optimize/refine_scores.h"
#include "refine/refine.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetrec {
namespace {

// A trial that would keep more of the vertices is not worth its steps.
constexpr double kMostKept = 0.75;
// A trial that keeps less shows nothing if it fails: 1/256 of 2,000 vertices is no mesh.
constexpr double kLeastKept = 1.0 / 16;
// The longest trial, up to its last motion. The coarsest meshes would gain by more steps, but steps
// are also needed after it.
constexpr double kMostSteps = 400;
// A gain is clear if it exceeds its standard error by this; pictures are far from matched if they
// lack more than this [dB].
constexpr double kClearGain = 0.3, kFarFromMatched = 5;

double PsnrOf(std::span<const ErrorSum> views) {
  ErrorSum all;
  for (const ErrorSum& view : views) all.Add(view);
  return all.Psnr();
}

bool IsWanted(const OptimizeOptions& options) {
  const bool chooses_size = options.budget == BudgetChoice::kAuto && !options.schedule.rounds;
  const bool knows_need = options.refine == RefineScheme::kInsert &&
                          ScoreOf(options) == RefineScore::kResidual &&
                          options.storage == FieldStorage::kVertex;
  return chooses_size && knows_need && options.judging_pictures == JudgingPictures::kKept;
}

}  // namespace

bool IsExpectedToFail(const JudgedGain& failed, double kept_share, double milder_share) {
  return failed.gain * (1 - milder_share) / (1 - kept_share) < -failed.standard_error;
}

bool StillGains(const RoundsState& rounds, double matched_psnr) {
  if (rounds.steps.size() < 2) return false;
  const GrowthStep& last = rounds.steps.back();
  const GrowthStep& before = rounds.steps[rounds.steps.size() - 2];
  const bool has_grown = last.vertices > before.vertices;
  return last.decision == GrowthDecision::kRefine && has_grown &&
         last.gain - last.gain_standard_error > kClearGain &&
         last.psnr < matched_psnr - kFarFromMatched;
}

Coarsening::Coarsening(const OptimizeOptions& options, const RefinedParts& parts,
                       RefinementRounds& rounds, const std::filesystem::path& finer_file,
                       const std::filesystem::path& coarser_file)
    : options_(options),
      parts_(parts),
      rounds_(rounds),
      finer_file_(finer_file),
      coarser_file_(coarser_file),
      is_wanted_(IsWanted(options)) {}

bool Coarsening::IsDue(double progress) const {
  if (IsOver() || !rounds_.IsOver() || parts_.pictures.learns_all()) return false;
  const std::vector<GrowthStep>& steps = rounds_.state().steps;
  const uint64_t last = steps.empty() ? 0 : steps.back().iteration;
  const uint64_t iteration = parts_.steps.iteration();
  if (iteration < last + kFewestTrialSteps) return false;
  // A trial must end while pictures judge: otherwise, a resumed run would not make it.
  const double left = options_.schedule.last_judging - progress;
  return double(StepsOfTrial()) * progress < left * double(iteration);
}

bool Coarsening::Advance(double seconds, const RunMoment& moment) {
  const bool is_short = options_.HasLimit() && !rounds_.HasLateRounds();
  if (is_short && StillGains(rounds_.state(), options_.schedule.matched_psnr)) {
    state_.ended = 1;
    LogInfo("no coarser mesh is tried: the judging pictures still gained by the last rounds");
    return false;
  }
  const CoarseningState before = state_;
  const uint64_t iteration = parts_.steps.iteration(), rays = parts_.steps.rays();
  const WaitingField finer = Save(finer_file_);
  if (state_.reference.empty()) {
    if (LookAtFinest(moment)) return false;
  } else if (const auto is_coarser = TryCoarser(finer, seconds, moment)) {
    return *is_coarser;
  }
  PutBack(finer);
  parts_.steps.Resume(iteration, rays);
  state_ = before;
  return false;
}

// Returns true if the mesh has become coarser, and nothing if the run is asked to stop meanwhile.
std::optional<bool> Coarsening::TryCoarser(const WaitingField& finer, double seconds,
                                           const RunMoment& moment) {
  const uint64_t steps = StepsOfTrial();
  if (!DropLeastNeeded()) {
    state_.ended = 1;
    PutBack(finer);
    return false;
  }
  if (!parts_.steps.TryUnlessStopped(steps, kRatesOfTrials, moment)) return std::nullopt;
  const Judgement judgement = parts_.pictures.JudgeField();
  const GrowthStep coarser = StepOf(seconds, parts_.steps.iteration(), parts_.field.mesh());
  const bool is_matched = IsMatched(judgement, options_.schedule);
  bool stays = is_matched || IsAsGood(judgement.views);
  if (!stays) {
    PutBack(finer);
  } else if (!is_matched) {
    const std::optional<bool> learns_more = FinerLearnsMore(finer, judgement.views, steps, moment);
    if (!learns_more) return std::nullopt;
    stays = !*learns_more;
  }
  Record(coarser, judgement, stays);
  if (stays) parts_.steps.CountTried(steps);
  ChooseNextShare(stays, judgement.views);
  return stays;
}

// `views`: the errors of the judging pictures with the coarser mesh.
void Coarsening::ChooseNextShare(bool stays, std::span<const ErrorSum> views) {
  if (stays) {
    RaiseReference({views.begin(), views.end()});
    if (state_.has_failed == 0) {
      state_.kept_share = std::max(state_.kept_share * state_.kept_share, kLeastKept);
    }
    return;
  }
  state_.has_failed = 1;
  const double milder = std::sqrt(state_.kept_share);
  const JudgedGain gain = GainBetween(state_.reference, views);
  // Pictures that are more than matched may lose something.
  const bool may_lose = PsnrOf(state_.reference) > options_.schedule.matched_psnr;
  if (milder > kMostKept || (!may_lose && IsExpectedToFail(gain, state_.kept_share, milder))) {
    state_.ended = 1;
  }
  state_.kept_share = milder;
}

// What fewer vertices have to take over takes longer to learn, and costs less. A trial ends with a
// motion, because gradients that wait for one are lost when a run is stopped.
uint64_t Coarsening::StepsOfTrial() const {
  const double vertices = state_.kept_share * double(parts_.field.mesh().positions.size());
  const double longer = std::sqrt(std::max(double(state_.finest_vertices) / vertices, 1.0));
  const uint64_t steps = TrialSteps(parts_.steps.iteration());
  return parts_.motion.StepsToAMotion(
      parts_.steps.iteration(),
      uint64_t(std::clamp(double(steps) * longer, double(steps), kMostSteps)));
}

WaitingField Coarsening::Save(const std::filesystem::path& file) const {
  return WaitingField(file, parts_.field, parts_.motion);
}

void Coarsening::PutBack(const WaitingField& waiting) {
  waiting.PutBack(parts_.field, parts_.motion);
}

// Returns false if the run is asked to stop meanwhile.
bool Coarsening::LookAtFinest(const RunMoment& moment) {
  const uint64_t iteration = parts_.steps.iteration();
  const uint64_t steps = parts_.motion.StepsToAMotion(iteration, TrialSteps(iteration));
  const uint64_t vertices = parts_.field.mesh().positions.size();
  state_.finest_vertices = std::max(state_.finest_vertices, vertices);
  if (!parts_.steps.TryUnlessStopped(steps, kRatesOfTrials, moment)) return false;
  parts_.steps.CountTried(steps);
  state_.reference = parts_.pictures.JudgeField().views;
  return true;
}

// Returns false if the mesh would get no coarser.
bool Coarsening::DropLeastNeeded() {
  const size_t tets = parts_.field.mesh().tets.size();
  RefineScores scores = LookAtScores(parts_.renderer, parts_.pictures.set(), parts_.batches,
                                     options_, parts_.steps.iteration());
  for (const float room : parts_.field.RoomOfVertices()) scores.is_kept.push_back(room <= 0.0f);
  RefineOptions coarsen;
  coarsen.growth = 0;
  coarsen.max_vertices = parts_.field.mesh().positions.size();
  coarsen.kept_share = state_.kept_share;
  coarsen.seed = options_.seed;
  const FieldState before = parts_.field.ReadState();
  RefineResult result = Refine(parts_.field.TakeMesh(), before, scores, coarsen);
  const bool is_coarser = result.mesh.tets.size() < tets;
  parts_.field.Put(std::move(result.mesh), std::move(result.state));
  parts_.motion.Follow(result.of_vertices);
  return is_coarser;
}

bool Coarsening::IsAsGood(std::span<const ErrorSum> views) const {
  const JudgedGain gain = GainBetween(state_.reference, views);
  return gain.gain >= -gain.standard_error;
}

void Coarsening::RaiseReference(std::vector<ErrorSum> views) {
  if (GainBetween(state_.reference, views).gain > 0) state_.reference = std::move(views);
}

// Lets the finer mesh learn as many steps as the coarser one, which steps alone may have made as
// good. Whichever is better is the field then. Nothing if the run is asked to stop meanwhile.
std::optional<bool> Coarsening::FinerLearnsMore(const WaitingField& finer,
                                                std::span<const ErrorSum> coarser, uint64_t steps,
                                                const RunMoment& moment) {
  const WaitingField waiting = Save(coarser_file_);
  PutBack(finer);
  if (!parts_.steps.TryUnlessStopped(steps, kRatesOfTrials, moment)) return std::nullopt;
  RaiseReference(parts_.pictures.JudgeField().views);
  if (IsAsGood(coarser)) {
    PutBack(waiting);
    return false;
  }
  parts_.steps.CountTried(steps);
  return true;
}

// `step`: of the coarser mesh.
void Coarsening::Record(GrowthStep step, const Judgement& judgement, bool stays) {
  const JudgedGain gain = GainBetween(state_.reference, judgement.views);
  step.psnr = judgement.psnr;
  step.gain = gain.gain;
  step.gain_standard_error = gain.standard_error;
  step.decision = stays ? GrowthDecision::kCoarsen : GrowthDecision::kTooCoarse;
  rounds_.Record(step);
  LogInfo(
      "judging pictures with {} vertices, {} tets: {:.2f} dB; gain {:+.2f} dB, standard error "
      "{:.2f}: {}",
      WithThousands(step.vertices), WithThousands(step.tets), judgement.psnr, gain.gain,
      gain.standard_error, stays ? "the coarser mesh stays" : "the finer mesh stays");
}

}  // namespace tetrec
