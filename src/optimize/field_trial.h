// Trials of what a run could do: the field is trained on in two ways from the same state, by the
// same batches, and what comes out is compared.
//
// Nothing of it stays but the decision. A trial ends by low rates, whose field has less noise than
// one of the run: judged soon after, it would seem that much better, and the next round of
// refinement a loss (lego lost 1 dB of a run of two minutes by that).
#pragma once

#include "optimize/fitted_field.h"
#include "optimize/training_steps.h"

#include <cstdint>

namespace tetrec {

// The mesh stays as it is. Before each way, the caller sets what the ways differ in; the field is
// left as the last way trained it, until TakeBack.
class FieldTrial {
 public:
  // Each way takes `count` steps, as at the end of a run.
  FieldTrial(FittedField& field, TrainingSteps& steps, uint64_t count);

  // The field before the trial.
  const FieldState& before() const { return before_; }
  // Trains the field on from before the trial, or from `start`. Returns false if the run is asked
  // to stop meanwhile: field and steps are then as before the trial.
  bool Train();
  bool TrainFrom(FieldState start);
  void TakeBack();

 private:
  bool TakeSteps();

  FittedField& field_;
  TrainingSteps& steps_;
  uint64_t count_, iteration_, rays_;
  FieldState before_;
  bool is_trained_ = false;
};

}  // namespace tetrec
