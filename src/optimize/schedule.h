// The schedule of a run, as functions of its progress in [0, 1].
#pragma once

#include <cstdint>
#include <optional>

namespace tetrec {

struct ScheduleOptions {
  std::optional<int> rounds;  // refinements; by default as many as PlanGrowth finds
  double last_round = 0.55;   // progress at the last refinement; the rest settles
  // Share to which the learning rates fall exponentially; by default they fall as RateShare does.
  std::optional<double> final_rate_share;
  double fine_rays = 0.75;  // progress from which pixels may be learned by 2 x 2 rays each
  // Until this progress the judging pictures are kept from learning.
  double last_judging = 0.7;
  // A refinement that loses more than this on the judging pictures is taken back [dB].
  double judged_loss = 0.1;
  // Steps before each refinement of a run by time: on a slow machine a round may be due before the
  // mesh is fitted, and a mesh that is not fitted cannot be judged.
  uint64_t min_round_steps = 150;
};

// The learning rates at a progress, as a share of the first ones. For three quarters of a run they
// fall slowly, as what is new must still be learned, then fast, so that the noise of batches
// settles. `steps`: of the whole run, as far as is known. The more there are, the further rates
// fall before the end: a short run ends before all is learned, in a long one noise does harm.
double RateShare(const ScheduleOptions& options, double progress, double steps);

// How a mesh grows in a run.
struct GrowthPlan {
  int rounds;
  uint64_t max_vertices;
};

// Unless the options give their number, as many rounds, 3 to 9, as multiply the vertices by 4/3
// each: errors that are looked at more often place vertices better, but every look takes time.
GrowthPlan PlanGrowth(const ScheduleOptions& options, uint64_t vertices, uint64_t max_vertices);

// The progress at which round `round` (from 0) is due. The first rounds follow each other quickly,
// because a coarse mesh is fitted fast and cheaply.
double RoundProgress(const ScheduleOptions& options, const GrowthPlan& plan, int round);

// The growth in round `round` with which equal factors lead from `vertices` to the most in the
// rounds that are left, but no more than 2.5.
double RoundGrowth(const GrowthPlan& plan, int round, uint64_t vertices);

// The number of vertices that a run can fit, and needs. Measured on two cores: with vertices that
// move, 100 k give lego at 200x200 after 120 s 0.2 dB more than 180 k, and the demo 0.3 dB less but
// a better surface (F-score 0.93 against 0.87). Never more than one per 16 pixels: with one per
// ten, the demo's images gain nothing and its surface breaks up.
uint64_t AffordableVertices(double seconds, uint64_t pixels);

}  // namespace tetrec
