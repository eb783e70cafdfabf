// The steps of a run, one after another: each draws its batch and has its learning rates.
#include "optimize/training_steps.h"

#include <algorithm>

namespace tetrec {

StepResult TrainingSteps::Take(double progress, bool sums_exposures) {
  TrainingBatch batch = Draw(iteration_, progress);
  batch.sums_exposures = sums_exposures;
  ++iteration_;
  return renderer_.Step(batch, UpdateOf(iteration_, progress));
}

void TrainingSteps::Try(uint64_t count, double progress) {
  for (uint64_t iteration = iteration_; iteration < iteration_ + count; ++iteration) {
    renderer_.Step(Draw(iteration, progress), UpdateOf(iteration + 1, progress));
  }
}

TrainingBatch TrainingSteps::Draw(uint64_t iteration, double progress) {
  const double rays_per_pixel = double(rays_) / double(batches_.SubjectPixels());
  const TrainingBatch batch =
      batches_.Draw(iteration, SamplesPerSide(options_.schedule, progress, rays_per_pixel));
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
