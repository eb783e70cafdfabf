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

  // Holds the trial if it is due at this moment of the run; returns whether it was.
  bool Advance(const RunMoment& moment);
  // Lets vertices move, whatever a trial decided, unless the options say how they move: the mesh
  // has become coarser. A ball of one colour ends at 41.0 dB with 1,107 tets if its vertices move,
  // and at 38.3 dB with 2,353 if they stay, although the first 40 steps of motion lose 2 dB.
  void LetCoarserMeshMove();

 private:
  void Decide(bool moves);
  uint64_t StepsOfTrial() const;
  // The PSNR of the judging pictures after some steps more [dB].
  double TrialPsnr(bool moves, const RunMoment& moment);

  const OptimizeOptions& options_;
  FittedField& field_;
  TrainingPictures& pictures_;
  TrainingSteps& steps_;
  VertexMotion& motion_;
  TrialState state_ = TrialState::kNotTried;
};

}  // namespace tetrec
