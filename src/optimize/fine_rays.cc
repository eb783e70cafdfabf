// The choice between one ray and 2 x 2 rays per pixel once a run has grown.
#include "optimize/fine_rays.h"

#include "core/log.h"

#include <algorithm>

namespace tetrec {
namespace {

// In a short run, shortly before the judging pictures are learned.
constexpr double kTrialGrowth = 0.66;
static_assert(kTrialGrowth < ScheduleOptions().last_judging);
// The trial takes this part of the steps so far. After fewer than 100 steps scenes hardly differ,
// so shorter runs hold none.
constexpr uint64_t kPartOfSteps = 10, kMostSteps = 1000;
constexpr uint64_t kFewestStepsBefore = 100 * kPartOfSteps;

}  // namespace

FineRays::FineRays(const OptimizeOptions& options, FittedField& field, TrainingPictures& pictures,
                   TrainingSteps& steps)
    : field_(field), pictures_(pictures), steps_(steps) {
  if (options.fine_rays != FineRaysChoice::kAuto) Decide(options.fine_rays == FineRaysChoice::kOn);
}

void FineRays::Resume(TrialState state) {
  if (state != TrialState::kNotTried) Decide(state == TrialState::kUsed);
}

void FineRays::Decide(bool uses_fine_rays) {
  state_ = uses_fine_rays ? TrialState::kUsed : TrialState::kNotUsed;
  steps_.UseFineRays(uses_fine_rays);
  // Judged by one ray per pixel, a field that was learned by 2 x 2 would not look better.
  pictures_.JudgeBy(uses_fine_rays ? 2 : 1);
}

bool FineRays::Advance(double growth) {
  if (state_ != TrialState::kNotTried || growth < kTrialGrowth) return false;
  if (pictures_.learns_all() || !steps_.CanTakeFineRays() ||
      steps_.iteration() < kFewestStepsBefore) {
    Decide(false);
    return false;
  }
  const FieldState before = field_.ReadState();
  const uint64_t iteration = steps_.iteration(), rays = steps_.rays();
  const uint64_t steps = std::min(iteration / kPartOfSteps, kMostSteps);
  const std::optional<double> four = TrialPsnr(before, true, steps);
  const std::optional<double> one =
      four ? TrialPsnr(before, false, steps) : std::optional<double>();
  if (!one) {
    field_.PutState(before);
    steps_.UseFineRays(false);
    steps_.Resume(iteration, rays);
    return false;
  }
  const FineRaysTrial trial{.one_psnr = *one, .four_psnr = *four};
  trial_ = trial;
  // What was learned by one ray per pixel is kept.
  if (trial.PrefersFour()) {
    field_.PutState(before);
  } else {
    steps_.CountTried(steps);
  }
  Decide(trial.PrefersFour());
  LogInfo(
      "judging pictures after {} steps: {:.2f} dB by 2 x 2 rays per pixel, {:.2f} dB by one: the "
      "rest of the run takes {}",
      steps, trial.four_psnr, trial.one_psnr, trial.PrefersFour() ? "2 x 2" : "one");
  return true;
}

std::optional<double> FineRays::TrialPsnr(const FieldState& start, bool fine, uint64_t steps) {
  field_.PutState(start);
  steps_.UseFineRays(fine);
  if (!steps_.TryUnlessStopped(steps, kRatesOfTrials)) return {};
  return pictures_.JudgeField(2).psnr;
}

}  // namespace tetrec
