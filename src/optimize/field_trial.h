// Short trials of alternatives during a run: the field is trained on in two ways from the same
// state, by the same steps, and the results are compared.
//
// A trial ends at low learning rates, which leave less noise than those of the run. While rounds of
// refinement are still to come, nothing of it must stay but the decision: a field that is judged
// soon after it would look that much better, and the next round a loss (in two minutes, lego lost
// half a decibel by that).
#pragma once

#include "optimize/fitted_field.h"
#include "optimize/training_steps.h"

#include <cstdint>

namespace tetrec {

// The mesh stays as it is. Before each way, the caller sets up whatever distinguishes the two; the
// field is left as the last way trained it, until TakeBack. No gradients may wait for a motion
// (VertexMotion::CanResumeAfter): they are lost.
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
  // Counts the steps of one way, for a field that stays as it was trained.
  void CountSteps() { steps_.CountTried(count_); }

 private:
  bool TakeSteps();

  FittedField& field_;
  TrainingSteps& steps_;
  uint64_t count_, iteration_, rays_;
  FieldState before_;
  bool is_trained_ = false;
};

}  // namespace tetrec
