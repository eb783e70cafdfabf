// The steps of a run, one after another: each draws its batch and has its learning rates.
#include "optimize/training_steps.h"

#include "core/stop_request.h"

#include <algorithm>

namespace tetrec {
namespace {

constexpr uint64_t kStepsBetweenLooks = 16;  // for a request to stop

constexpr float kAlphaWeight = 1.0f;  // like that of a channel

}  // namespace

uint64_t TrialSteps(uint64_t iteration) {
  return std::clamp(iteration / 48, kFewestTrialSteps, kMostTrialSteps);
}

StepResult TrainingSteps::Take(const RunMoment& moment, bool sums_exposures) {
  return TakeStep(iteration_++, moment, moment, sums_exposures);
}

void TrainingSteps::Try(uint64_t count, const RunMoment& as_at,
                        std::optional<RunMoment> motion_as_at) {
  for (uint64_t iteration = iteration_; iteration < iteration_ + count; ++iteration) {
    TakeStep(iteration, as_at, motion_as_at, false);
  }
}

bool TrainingSteps::TryUnlessStopped(uint64_t count, const RunMoment& as_at,
                                     std::optional<RunMoment> motion_as_at) {
  const uint64_t first = iteration_;
  bool stopped = StopRequested();
  for (uint64_t tried = 0; tried < count && !stopped; tried += kStepsBetweenLooks) {
    iteration_ = first + tried;
    Try(std::min(count - tried, kStepsBetweenLooks), as_at, motion_as_at);
    stopped = StopRequested();
  }
  iteration_ = first;
  return !stopped;
}

StepResult TrainingSteps::TakeStep(uint64_t iteration, const RunMoment& moment,
                                   std::optional<RunMoment> motion_as_at, bool sums_exposures) {
  TrainingBatch batch = Draw(iteration, moment);
  batch.sums_exposures = sums_exposures;
  const uint64_t steps = iteration + 1;
  batch.parts =
      motion_as_at ? motion_.PartsOf(steps, motion_as_at->progress) : GradientParts::kColorDensity;
  const StepResult result = renderer_.Step(batch, UpdateOf(steps, moment));
  if (motion_as_at) {
    motion_.AfterStep(steps, motion_as_at->progress,
                      RateShare(options_.schedule, *motion_as_at, motion_.StepsForRates(steps)));
  }
  return result;
}

TrainingBatch TrainingSteps::Draw(uint64_t iteration, const RunMoment& moment) {
  const bool fine = uses_fine_rays_ && moment.growth >= options_.schedule.fine_rays;
  TrainingBatch batch = batches_.Draw(iteration, fine ? 2 : 1);
  if (options_.background == BackgroundChoice::kAuto && has_alpha_) {
    batch.background_srgb = batches_.background_of_scene_srgb();
    batch.alpha_weight = kAlphaWeight;
  }
  rays_ += batch.rays();
  return batch;
}

AdamUpdate TrainingSteps::UpdateOf(uint64_t step, const RunMoment& moment) const {
  const double share = share_of_rates_ * RateShare(options_.schedule, moment, step);
  return {.step = uint32_t(std::min<uint64_t>(step, 1u << 30)),
          .color_rate = first_rates_.color * share,
          .density_rate = first_rates_.density * share,
          .harmonics_rate = first_rates_.harmonics * share,
          .max_density = options_.max_density,
          .density_decay = density_decay_,
          .harmonics_decay = options_.harmonics_decay};
}

}  // namespace tetrec
