// Short trials of alternatives during a run.
#include "optimize/field_trial.h"

#include <utility>

namespace tetrec {

FieldTrial::FieldTrial(FittedField& field, TrainingSteps& steps, uint64_t count)
    : field_(field),
      steps_(steps),
      count_(count),
      iteration_(steps.iteration()),
      rays_(steps.rays()),
      before_(field.ReadState()) {}

bool FieldTrial::Train() {
  if (is_trained_) TakeBack();
  return TakeSteps();
}

bool FieldTrial::TrainFrom(FieldState start) {
  field_.PutState(std::move(start));
  return TakeSteps();
}

void FieldTrial::TakeBack() { field_.PutState(before_); }

bool FieldTrial::TakeSteps() {
  is_trained_ = true;
  if (steps_.TryUnlessStopped(count_, kRatesOfTrials)) return true;
  TakeBack();
  steps_.Resume(iteration_, rays_);
  return false;
}

}  // namespace tetrec
