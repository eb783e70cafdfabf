// The choice whether vertices move in a run, and from when on: by a trial, and if there are no
// pictures that could judge it, they do, because every scene that was measured gained by it.
#pragma once

#include "optimize/fitted_field.h"
#include "optimize/optimize_options.h"
#include "optimize/training_pictures.h"
#include "optimize/training_steps.h"
#include "optimize/vertex_motion.h"

namespace tetrec {

class MotionTrial {
 public:
  MotionTrial(const OptimizeOptions& options, FittedField& field, TrainingPictures& pictures,
              TrainingSteps& steps, VertexMotion& motion);

  void Resume(TrialState state);
  TrialState state() const { return state_; }

  // Holds the trial if it is due at this growth and progress of the run; returns whether it was.
  bool Advance(double growth, double progress);
  // Lets the trial be repeated if it decided that vertices stay: a coarser mesh gains more by
  // motion.
  void Reconsider();

 private:
  void Decide(bool moves);
  // The PSNR of the judging pictures after some steps more [dB].
  double TrialPsnr(bool moves, double progress);

  const OptimizeOptions& options_;
  FittedField& field_;
  TrainingPictures& pictures_;
  TrainingSteps& steps_;
  VertexMotion& motion_;
  TrialState state_ = TrialState::kNotTried;
};

}  // namespace tetrec
