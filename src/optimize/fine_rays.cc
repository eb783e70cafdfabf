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
    : field_(field), pictures_(pictures), steps_(steps) {
  const bool is_tried = options.fine_rays == FineRaysChoice::kAuto && has_alpha;
  if (!is_tried) Decide(options.fine_rays == FineRaysChoice::kOn);
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
  const uint64_t steps =
      std::clamp(steps_.iteration() / kPartOfFineTrial, kFewestFineSteps, kMostFineSteps);
  FieldTrial trial(field_, steps_, steps);
  // 2 x 2 rays last, because what the likelier way learns can stay.
  const std::optional<double> one = TrialPsnr(trial, false);
  const std::optional<double> four = one ? TrialPsnr(trial, true) : std::nullopt;
  if (!four) {
    steps_.UseFineRays(false);
    return false;
  }
  result_ = FineRaysTrial{.one_psnr = *one, .four_psnr = *four};
  const bool prefers_four = result_->PrefersFour();
  if (prefers_four) {
    trial.CountSteps();
  } else {
    trial.TakeBack();
  }
  Decide(prefers_four);
  LogInfo(
      "judging pictures after {} steps: {:.2f} dB by 2 x 2 rays per pixel, {:.2f} dB by one: the "
      "rest of the run takes {}",
      steps, result_->four_psnr, result_->one_psnr, prefers_four ? "2 x 2" : "one");
  return true;
}

std::optional<double> FineRays::TrialPsnr(FieldTrial& trial, bool fine) {
  steps_.UseFineRays(fine);
  if (!trial.Train()) return {};
  return pictures_.JudgeField(2).psnr;
}

}  // namespace tetrec
