// The end of a run without limits: it ends once the judging pictures gain no more.
#pragma once

#include "optimize/judging.h"

#include <cstdint>
#include <optional>
#include <vector>

namespace tetrec {

// What a resumed run needs.
struct ConvergenceState {
  uint64_t last_look = 0;            // steps at the last look at the judging pictures
  uint64_t converged = 0;            // steps at which they gained no more; 0: not yet
  std::vector<ErrorSum> last_views;  // what they said at the last look
  bool operator==(const ConvergenceState&) const = default;
};

// Looks at the judging pictures whenever the run has become longer by a quarter. Since steps that
// cost the same gain less and less, what the last quarter has not gained, the next will not.
class Convergence {
 public:
  void Resume(ConvergenceState state) { state_ = std::move(state); }
  const ConvergenceState& state() const { return state_; }

  // After `steps` steps.
  bool IsDue(uint64_t steps) const;
  // `may_end`: the mesh is refined no more. Returns the gain since the last look [dB], if there was
  // one.
  std::optional<double> Look(uint64_t steps, std::vector<ErrorSum> views, bool may_end);

  // The progress of the run in [0, 1]: below ScheduleOptions::last_judging until it has converged;
  // then the rest, in which all pictures are learned and the rates fall, takes its share.
  double Progress(uint64_t steps) const;

 private:
  ConvergenceState state_;
};

}  // namespace tetrec
