// The choice between one ray and 2 x 2 rays per pixel in the last part of a run.
//
// A pixel shows the mean of what lies in it. Learned by one ray, a field is as blurred as pixels
// are; learned by the mean of four rays, it has what they sum up. But a step then informs about a
// quarter of the pixels. Where each pixel is learned often, that is worth +0.7 dB on opaque
// subjects (lego after 4,000 steps); where the photos determine little more than what they show, it
// loses as much (demo). So a trial decides.
#pragma once

#include "core/words.h"
#include "optimize/fitted_field.h"
#include "optimize/optimize_options.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"

namespace tetrec {

class FineRays {
 public:
  FineRays(const OptimizeOptions& options, FittedField& field, TrainingPictures& pictures,
           TrainingSteps& steps);

  void Resume(FineRaysState state);
  FineRaysState state() const { return state_; }

  // Holds the trial if it is due at this progress of the run; returns whether it was.
  bool Advance(double progress);

 private:
  void Decide(bool uses_fine_rays);
  // The PSNR of the judging pictures after some steps, which are not counted, as at the end of a
  // run [dB].
  double TrialPsnr(const FieldState& start, bool fine, double progress);

  const OptimizeOptions& options_;
  FittedField& field_;
  TrainingPictures& pictures_;
  TrainingSteps& steps_;
  FineRaysState state_ = FineRaysState::kNotTried;
};

}  // namespace tetrec
