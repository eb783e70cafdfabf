// When what happens in a run, as functions of its progress in [0, 1].
#pragma once

#include <cstdint>

namespace tetrec {

struct ScheduleOptions {
  int rounds = 5;                  // refinements
  double last_round = 0.55;        // progress at the last refinement; the rest settles
  double final_rate_share = 0.05;  // learning rates fall exponentially to this share
  // Steps before each refinement of a run by time: on a slow machine a round may be due before the
  // mesh was taught, and an untaught mesh cannot be judged.
  uint64_t min_round_steps = 150;
};

// Share of the first learning rates at a progress.
double RateShare(const ScheduleOptions& options, double progress);

// Progress at which round `round` (from 0) is due. The first rounds come soon after one another: a
// coarse mesh settles fast and cheaply.
double RoundProgress(const ScheduleOptions& options, int round);

// Growth of round `round` so that equal factors lead from `vertices` to `max_vertices` in the
// rounds that are left; at most 2.5.
double RoundGrowth(const ScheduleOptions& options, int round, uint64_t vertices,
                   uint64_t max_vertices);

// How many vertices a run can teach: measured on NeRF-synthetic lego at 200x200 and two cores,
// where 180 k after 120 s were still gaining. Never more than one for 16 pixels: with one for ten
// the demo's pictures gain nothing and its surface breaks up.
uint64_t AffordableVertices(double seconds, uint64_t pixels);

}  // namespace tetrec
