// The check at the beginning of a run that its learning rates are not too high. Steps that are too
// long spoil a good start within a few steps, and what they spoil the rest of the run cannot mend.
#pragma once

#include "optimize/fitted_field.h"
#include "optimize/optimize_options.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"

namespace tetrec {

class RateTrial {
 public:
  RateTrial(const OptimizeOptions& options, FittedField& field, TrainingPictures& pictures,
            TrainingSteps& steps)
      : options_(options), field_(field), pictures_(pictures), steps_(steps) {}

  // Before the first step, if there are pictures that judge: takes a few steps. If the judging
  // pictures lose clearly by them, it starts again with a tenth of the rates, and again, until they
  // lose next to nothing, with a warning; or continues with the rates as they are, if lower ones
  // are not clearly better. Returns whether it took any step.
  bool Advance();

 private:
  // The PSNR of the judging pictures after the steps of a trial at this share of the rates [dB].
  double TrialPsnr(double share);

  const OptimizeOptions& options_;
  FittedField& field_;
  TrainingPictures& pictures_;
  TrainingSteps& steps_;
};

}  // namespace tetrec
