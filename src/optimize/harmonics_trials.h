// View-dependent colour in a run: degrees of harmonics are unlocked one after another, and with
// HarmonicsChoice::kAuto a trial decides whether the last one stays.
#pragma once

#include "optimize/fitted_field.h"
#include "optimize/harmonics.h"
#include "optimize/optimize_options.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"

#include <cstdint>

namespace tetrec {

class HarmonicsTrials {
 public:
  HarmonicsTrials(const OptimizeOptions& options, FittedField& field, TrainingPictures& pictures,
                  TrainingSteps& steps)
      : options_(options), field_(field), pictures_(pictures), steps_(steps) {}

  void Resume(const HarmonicsState& state) { state_ = state; }
  const HarmonicsState& state() const { return state_; }

  // Does what is due at this progress of the run; returns whether anything was.
  bool Advance(double progress);

 private:
  void Unlock();
  void Judge(double progress);
  // The PSNR of the judging pictures after some steps more [dB].
  double TrialPsnr(uint64_t steps, double progress);

  const OptimizeOptions& options_;
  FittedField& field_;
  TrainingPictures& pictures_;
  TrainingSteps& steps_;
  HarmonicsState state_;
};

}  // namespace tetrec
