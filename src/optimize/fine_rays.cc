// The choice between one ray and 2 x 2 rays per pixel once a run has grown.
#include "optimize/fine_rays.h"

#include "core/log.h"

#include <algorithm>

namespace tetrec {
namespace {

// In a short run, shortly before the judging pictures are learned.
constexpr double kTrialGrowth = 0.66;
static_assert(kTrialGrowth < ScheduleOptions().last_judging);
// The trial takes this part of the steps so far, in each of both ways. After fewer than 100 steps,
// scenes hardly differ.
constexpr uint64_t kPartOfFineTrial = 16, kFewestFineSteps = 100, kMostFineSteps = 1000;
// In shorter runs the trial would take a large share of the steps.
constexpr uint64_t kFewestStepsBefore = 10 * kFewestFineSteps;

}  // namespace

FineRays::FineRays(const OptimizeOptions& options, bool has_alpha, FittedField& field,
                   TrainingPictures& pictures, TrainingSteps& steps)
    : has_alpha_(has_alpha), field_(field), pictures_(pictures), steps_(steps) {
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
  const uint64_t steps = std::clamp(iteration / kPartOfFineTrial, kFewestFineSteps, kMostFineSteps);
  // The likelier way last, because what it learns can stay.
  const std::optional<double> first = TrialPsnr(before, !has_alpha_, steps);
  const std::optional<double> last =
      first ? TrialPsnr(before, has_alpha_, steps) : std::optional<double>();
  if (!last) {
    field_.PutState(before);
    steps_.UseFineRays(false);
    steps_.Resume(iteration, rays);
    return false;
  }
  const FineRaysTrial trial = has_alpha_ ? FineRaysTrial{.one_psnr = *first, .four_psnr = *last}
                                         : FineRaysTrial{.one_psnr = *last, .four_psnr = *first};
  trial_ = trial;
  if (trial.PrefersFour() == has_alpha_) {
    steps_.CountTried(steps);
  } else {
    field_.PutState(before);
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
