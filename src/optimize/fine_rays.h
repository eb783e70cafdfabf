// The choice between one ray and 2 x 2 rays per pixel once a run has grown.
//
// A pixel shows the mean of what lies in it. Learned by one ray each, a field becomes as blurred as
// the pixels are; learned by means of four rays, it need not. But then a step informs about a
// quarter of the pixels. Pictures with alpha, whose outlines are sharp, often gain by it (lego 0.7
// dB after 4,000 steps), but not always, so a trial decides. Photos without alpha take one ray: fox
// and the demo ended worse by 2 x 2 (the demo by 0.4 dB after 2,400 steps), the turntable and the
// yard lost in their trials, and a trial costs 4 to 5 % of two minutes.
#pragma once

#include "optimize/field_trial.h"
#include "optimize/fitted_field.h"
#include "optimize/optimize_options.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"

#include <optional>

namespace tetrec {

// PSNR of the judging pictures after some steps with one ray and with 2 x 2 rays per pixel [dB].
struct FineRaysTrial {
  double one_psnr = 0, four_psnr = 0;
  // A trial shows only the beginning. On lego, where 2 x 2 rays gain in the end, they are 0.05 and
  // 0.01 dB behind and 0.07 dB ahead after 100, 200 and 400 steps. So they may lose a little.
  bool PrefersFour() const { return four_psnr > one_psnr - 0.09; }
};

class FineRays {
 public:
  // `has_alpha`: the training pictures have alpha.
  FineRays(const OptimizeOptions& options, bool has_alpha, FittedField& field,
           TrainingPictures& pictures, TrainingSteps& steps);

  void Resume(TrialState state);
  TrialState state() const { return state_; }

  // The trial of this process, if there was one.
  const std::optional<FineRaysTrial>& trial() const { return result_; }

  // Holds the trial if it is due at this growth of the run; returns whether it was held. If the run
  // is asked to stop meanwhile, everything is as before.
  bool Advance(double growth);

 private:
  void Decide(bool uses_fine_rays);
  // The PSNR of the judging pictures after one way of the trial [dB]. None if the run is asked to
  // stop meanwhile.
  std::optional<double> TrialPsnr(FieldTrial& trial, bool fine);

  FittedField& field_;
  TrainingPictures& pictures_;
  TrainingSteps& steps_;
  TrialState state_ = TrialState::kNotTried;
  std::optional<FineRaysTrial> result_;
};

}  // namespace tetrec
