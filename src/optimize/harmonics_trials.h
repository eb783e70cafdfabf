// View-dependent colour in a run: degrees of harmonics are unlocked one after another, and with
// HarmonicsChoice::kAuto the judging pictures decide which stay.
#pragma once

#include "optimize/fitted_field.h"
#include "optimize/harmonics.h"
#include "optimize/optimize_options.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"

#include <cstddef>
#include <cstdint>
#include <optional>

namespace tetrec {

class HarmonicsTrials {
 public:
  HarmonicsTrials(const OptimizeOptions& options, FittedField& field, TrainingPictures& pictures,
                  TrainingSteps& steps)
      : options_(options), field_(field), pictures_(pictures), steps_(steps) {}

  void Resume(const HarmonicsState& state) { state_ = state; }
  const HarmonicsState& state() const { return state_; }

  // Does what is due at this growth of the run; returns whether anything was. A trial during which
  // the run is asked to stop is not held: everything is then as before.
  bool Advance(double growth);

 private:
  void Unlock();
  bool Judge();
  // Takes the degree away if it does not stay. Empty, with the field as it was, if the run is asked
  // to stop meanwhile.
  std::optional<bool> HighestDegreeStays();
  size_t photos() const { return pictures_.set().views.size(); }

  const OptimizeOptions& options_;
  FittedField& field_;
  TrainingPictures& pictures_;
  TrainingSteps& steps_;
  HarmonicsState state_;
};

}  // namespace tetrec
