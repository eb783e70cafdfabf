// The end of a run without limits: it ends once the judging pictures gain no more.
#pragma once

#include <cstdint>

namespace tetrec {

// What a resumed run needs.
struct ConvergenceState {
  uint64_t last_look = 0;   // steps at the last look at the judging pictures
  uint64_t idle_looks = 0;  // since they gained
  uint64_t converged = 0;   // steps at which they gained no more; 0: not yet
  double best_psnr = 0;     // [dB]
  bool operator==(const ConvergenceState&) const = default;
};

// Looks at the judging pictures whenever the run has become longer by a quarter. The run has
// converged after two looks without a gain: one alone may be due to the noise of the learning
// rates.
class Convergence {
 public:
  void Resume(const ConvergenceState& state) { state_ = state; }
  const ConvergenceState& state() const { return state_; }

  // After `steps` steps.
  bool IsDue(uint64_t steps) const;
  // `psnr`: of the judging pictures [dB]. `may_end`: the mesh is refined no more.
  void Look(uint64_t steps, double psnr, bool may_end);

  // The progress of the run in [0, 1]: below ScheduleOptions::last_judging until it has converged;
  // then the rest, in which all pictures are learned and the rates fall, takes its share.
  double Progress(uint64_t steps) const;

 private:
  ConvergenceState state_;
};

}  // namespace tetrec
