// The schedule of a run, as functions of its progress in [0, 1].
#pragma once

#include <cstdint>

namespace tetrec {

struct ScheduleOptions {
  int rounds = 5;                  // refinements
  double last_round = 0.55;        // progress at the last refinement; the rest settles
  double final_rate_share = 0.05;  // learning rates fall exponentially to this share
  // Until this progress the judging pictures are kept from learning.
  double last_judging = 0.7;
  // A refinement that loses more than this on the judging pictures is taken back [dB].
  double judged_loss = 0.1;
  // Steps before each refinement of a run by time: on a slow machine a round may be due before the
  // mesh is fitted, and a mesh that is not fitted cannot be judged.
  uint64_t min_round_steps = 150;
};

// The learning rates at a progress, as a share of the first ones.
double RateShare(const ScheduleOptions& options, double progress);

// The progress at which round `round` (from 0) is due. The first rounds follow each other quickly,
// because a coarse mesh is fitted fast and cheaply.
double RoundProgress(const ScheduleOptions& options, int round);

// The growth in round `round` with which equal factors lead from `vertices` to `max_vertices` in
// the rounds that are left, but no more than 2.5.
double RoundGrowth(const ScheduleOptions& options, int round, uint64_t vertices,
                   uint64_t max_vertices);

// The number of vertices that a run can fit: measured on NeRF-synthetic lego at 200x200 and two
// cores, where 180 k were still improving after 120 s. Never more than one per 16 pixels: with one
// per ten, the demo's images gain nothing and its surface breaks up.
uint64_t AffordableVertices(double seconds, uint64_t pixels);

}  // namespace tetrec
