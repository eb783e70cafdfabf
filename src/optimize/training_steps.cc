// The steps of a run, one after another: each draws its batch and has its learning rates.
#include "optimize/training_steps.h"

#include <algorithm>

namespace tetrec {

StepResult TrainingSteps::Take(double progress, bool sums_exposures) {
  TrainingBatch batch = Draw(iteration_);
  batch.sums_exposures = sums_exposures;
  ++iteration_;
  return renderer_.Step(batch, UpdateOf(iteration_, progress));
}

void TrainingSteps::Try(uint64_t count, double progress) {
  for (uint64_t iteration = iteration_; iteration < iteration_ + count; ++iteration) {
    renderer_.Step(Draw(iteration), UpdateOf(iteration + 1, progress));
  }
}

TrainingBatch TrainingSteps::Draw(uint64_t iteration) {
  const TrainingBatch batch = batches_.Draw(iteration);
  rays_ += batch.rays();
  return batch;
}

AdamUpdate TrainingSteps::UpdateOf(uint64_t step, double progress) const {
  const double share = RateShare(options_.schedule, progress);
  return {.step = uint32_t(std::min<uint64_t>(step, 1u << 30)),
          .color_rate = options_.color_rate * share,
          .density_rate = options_.density_rate * share,
          .harmonics_rate = options_.harmonics_rate * share,
          .max_density = options_.max_density,
          .density_decay = options_.density_decay};
}

}  // namespace tetrec
