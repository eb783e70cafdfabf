// The steps of a run, one after another: each draws its batch and has its learning rates.
#pragma once

#include "optimize/batches.h"
#include "optimize/optimize_options.h"
#include "optimize/vertex_motion.h"
#include "render/training_renderer.h"

#include <cstdint>
#include <optional>

namespace tetrec {

// How long a trial trains on, in two ways, to compare them: for a part of the steps so far,
// within these bounds. Trials of other meshes, of 2 x 2 rays and of stray photos take longer.
inline constexpr uint64_t kFewestTrialSteps = 40, kMostTrialSteps = 100;
uint64_t TrialSteps(uint64_t iteration);

// The moment whose learning rates trials take: at those of their own time, noise would decide.
inline constexpr RunMoment kRatesOfTrials = AtProgress(0.95);

class TrainingSteps {
 public:
  // `has_alpha`: the training pictures have alpha.
  TrainingSteps(const OptimizeOptions& options, bool has_alpha, BatchDrawer& batches,
                TrainingRenderer& renderer, VertexMotion& motion)
      : options_(options),
        has_alpha_(has_alpha),
        first_rates_(FirstRatesOf(options, has_alpha)),
        density_decay_(options.density_decay.value_or(DensityDecay(has_alpha))),
        batches_(batches),
        renderer_(renderer),
        motion_(motion) {}

  uint64_t iteration() const { return iteration_; }  // steps counted so far
  uint64_t rays() const { return rays_; }            // of all steps, tried ones too
  void Resume(uint64_t iteration, uint64_t rays) { iteration_ = iteration, rays_ = rays; }

  // From ScheduleOptions::fine_rays on, pixels are learned by 2 x 2 rays each, or by one.
  void UseFineRays(bool fine) { uses_fine_rays_ = fine; }
  bool CanTakeFineRays() const { return !batches_.DrawsTiles(); }

  // `sums_exposures`: TrainingBatch::sums_exposures. The result is that of an earlier step
  // (TrainingRenderer::Step).
  StepResult Take(const RunMoment& moment, bool sums_exposures);
  // Takes the next `count` steps without counting them: the same steps can be taken again, from
  // another state of the field. Rates and rays per pixel are those of the moment `as_at`; vertices
  // move, if they do, as at the moment `motion_as_at`, or stay, because another state of the field
  // does not bring them back.
  void Try(uint64_t count, const RunMoment& as_at, std::optional<RunMoment> motion_as_at = {});
  // The same, but returns false as soon as the run is asked to stop.
  bool TryUnlessStopped(uint64_t count, const RunMoment& as_at,
                        std::optional<RunMoment> motion_as_at = {});
  void CountTried(uint64_t count) { iteration_ += count; }

  // Of the rates of colour, density and harmonics, from the next step on (rate_trial.h).
  void UseShareOfRates(double share) { share_of_rates_ = share; }
  double share_of_rates() const { return share_of_rates_; }

 private:
  // Step `iteration`, from 0.
  StepResult TakeStep(uint64_t iteration, const RunMoment& moment,
                      std::optional<RunMoment> motion_as_at, bool sums_exposures);
  TrainingBatch Draw(uint64_t iteration, const RunMoment& moment);
  // The update that ends step `step`, counted from 1.
  AdamUpdate UpdateOf(uint64_t step, const RunMoment& moment) const;

  const OptimizeOptions& options_;
  bool has_alpha_;
  FirstRates first_rates_;
  double density_decay_;
  BatchDrawer& batches_;
  TrainingRenderer& renderer_;
  VertexMotion& motion_;
  uint64_t iteration_ = 0, rays_ = 0;
  bool uses_fine_rays_ = false;
  double share_of_rates_ = 1;
};

}  // namespace tetrec
