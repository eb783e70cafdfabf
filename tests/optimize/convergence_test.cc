#include "optimize/convergence.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

// Takes steps until the run is over, while the judging pictures approach 30 dB.
uint64_t StepsOfRun(Convergence& convergence, double steps_per_halving, bool mesh_grows) {
  for (uint64_t steps = 0; steps < 1000000; ++steps) {
    if (convergence.Progress(steps) >= 1.0) return steps;
    if (convergence.IsDue(steps)) {
      convergence.Look(steps, 30 - 10 * std::exp2(-double(steps) / steps_per_halving), !mesh_grows);
    }
  }
  return 0;
}

TEST(Convergence, EndsARunOnceTheJudgingPicturesGainNoMore) {
  Convergence fast, slow;
  const uint64_t fast_steps = StepsOfRun(fast, 1000, false);
  const uint64_t slow_steps = StepsOfRun(slow, 4000, false);
  EXPECT_GT(fast_steps, 6000u);  // at 5,000 steps it still gains 0.2 dB per quarter
  EXPECT_GT(slow_steps, 2 * fast_steps);
  EXPECT_LT(slow_steps, 100000u);
}

TEST(Convergence, LeavesTheLastPartOfARunForWhatBelongsToIt) {
  Convergence run;
  const uint64_t steps = StepsOfRun(run, 1000, false);
  const uint64_t converged = run.state().converged;
  EXPECT_NEAR(double(converged) / double(steps), 0.7, 1e-3);
  EXPECT_GE(run.Progress(converged), 0.7);
  EXPECT_LT(run.Progress(converged), 0.71);
}

TEST(Convergence, BearsALookThatIsWorse) {
  Convergence run;
  run.Look(5000, 30.0, true);
  run.Look(6250, 29.8, true);
  run.Look(7900, 30.4, true);
  run.Look(9900, 30.3, true);
  EXPECT_EQ(run.state().converged, 0u);
  run.Look(12400, 30.42, true);
  EXPECT_EQ(run.state().converged, 12400u);
}

TEST(Convergence, CountsNoLookAtAMeshThatGrows) {
  Convergence run;
  run.Look(5000, 30.0, false);
  run.Look(6250, 30.0, false);
  run.Look(7900, 30.0, false);
  run.Look(9900, 30.0, true);
  EXPECT_EQ(run.state().converged, 0u);
  run.Look(12400, 30.0, true);
  EXPECT_EQ(run.state().converged, 12400u);
}

TEST(Convergence, WaitsForTheMesh) {
  Convergence run;
  EXPECT_EQ(StepsOfRun(run, 1000, true), 0u);
  EXPECT_LT(run.Progress(1000000), 0.65);
  EXPECT_GT(run.Progress(1000000), 0.6);
}

TEST(Convergence, ContinuesAsItWouldHave) {
  Convergence whole, resumed;
  for (uint64_t steps = 0; steps < 8000; ++steps) {
    if (whole.IsDue(steps)) whole.Look(steps, 20 + double(steps) / 1000, true);
  }
  resumed.Resume(whole.state());
  for (uint64_t steps = 8000; steps < 20000; ++steps) {
    ASSERT_EQ(whole.IsDue(steps), resumed.IsDue(steps));
    if (!whole.IsDue(steps)) continue;
    for (Convergence* run : {&whole, &resumed}) run->Look(steps, 24, true);
  }
  EXPECT_GT(whole.state().converged, 0u);
  EXPECT_TRUE(whole.state() == resumed.state());
}

}  // namespace
}  // namespace tetrec
