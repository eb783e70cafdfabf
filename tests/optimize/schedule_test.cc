#include "optimize/schedule.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

TEST(RateShare, FallsFromOne) {
  const ScheduleOptions options;
  for (const double steps : {1.0, 500.0, 5000.0, 1e6}) {
    EXPECT_EQ(RateShare(options, 0.0, steps), 1.0);
    double before = 1.0;
    for (int i = 1; i <= 100; ++i) {
      const double share = RateShare(options, i / 100.0, steps);
      EXPECT_LT(share, before);
      before = share;
    }
    EXPECT_GT(before, 0.0);
  }
}

TEST(RateShare, FallsFastAtTheEnd) {
  const ScheduleOptions options;
  const auto fall = [&](double from) {
    return RateShare(options, from, 4000) / RateShare(options, from + 0.25, 4000);
  };
  EXPECT_DOUBLE_EQ(fall(0.25), fall(0.5));  // exponential
  EXPECT_DOUBLE_EQ(fall(0.75), 10 * fall(0.5));
}

TEST(RateShare, FallsFurtherInLongerRuns) {
  const ScheduleOptions options;
  for (const double progress : {0.1, 0.5, 1.0}) {
    EXPECT_LT(RateShare(options, progress, 8000), RateShare(options, progress, 2000));
    EXPECT_EQ(RateShare(options, progress, 1e7), RateShare(options, progress, 1e6));
  }
}

TEST(RateShare, FallsExponentiallyToAGivenShare) {
  for (const double last : {1.0, 0.3, 0.05, 0.001}) {
    ScheduleOptions options;
    options.final_rate_share = last;
    EXPECT_EQ(RateShare(options, 0.0, 1000), 1.0);
    EXPECT_DOUBLE_EQ(RateShare(options, 1.0, 1000), last);
    EXPECT_DOUBLE_EQ(RateShare(options, 0.5, 1000), std::sqrt(last));  // the geometric mean
  }
}

TEST(RateShare, StaysAtItsEndsOutsideTheRun) {
  const ScheduleOptions options;
  EXPECT_EQ(RateShare(options, -0.5, 1000), 1.0);
  EXPECT_EQ(RateShare(options, 1.5, 1000), RateShare(options, 1.0, 1000));
}

TEST(PlanGrowth, HasMoreRoundsWhereThereIsMoreToGrow) {
  const ScheduleOptions options;
  EXPECT_EQ(PlanGrowth(options, 1000, 1000).rounds, 3);
  EXPECT_EQ(PlanGrowth(options, 1000, 500).rounds, 3);
  EXPECT_EQ(PlanGrowth(options, 1000, 4000).rounds, 5);
  EXPECT_EQ(PlanGrowth(options, 10, 1000000000).rounds, 9);
  EXPECT_EQ(PlanGrowth(options, 1000, 4000).max_vertices, 4000u);
}

TEST(PlanGrowth, TakesAGivenNumberOfRounds) {
  ScheduleOptions options;
  for (const int rounds : {0, 1, 40}) {
    options.rounds = rounds;
    EXPECT_EQ(PlanGrowth(options, 1000, 4000).rounds, rounds);
  }
}

TEST(RoundProgress, RisesToTheLastRound) {
  const ScheduleOptions options;
  for (const int rounds : {1, 2, 5, 12}) {
    double before = 0.0, gap_before = 0.0;
    for (int round = 0; round < rounds; ++round) {
      const double progress = RoundProgress(options, {rounds, 1000}, round);
      EXPECT_GT(progress, before);
      EXPECT_GT(progress - before, gap_before) << "the first rounds come soon after one another";
      gap_before = progress - before;
      before = progress;
    }
    EXPECT_DOUBLE_EQ(before, options.last_round);
  }
}

// Vertices after all rounds, if each round grows as much as it may.
double AfterAllRounds(const GrowthPlan& plan, uint64_t start) {
  uint64_t vertices = start;
  for (int round = 0; round < plan.rounds; ++round) {
    const double growth = RoundGrowth(plan, round, vertices);
    EXPECT_GE(growth, 1.0);
    EXPECT_LE(growth, 2.5);
    vertices = uint64_t(std::llround(double(vertices) * growth));
  }
  return double(vertices);
}

TEST(RoundGrowth, LeadsToTheBudget) {
  for (const int rounds : {1, 3, 5, 8}) {
    for (const double factor : {1.0, 1.3, 2.0, 2.4}) {
      const uint64_t start = 10000;
      const GrowthPlan plan{rounds, uint64_t(double(start) * std::pow(factor, rounds))};
      // The last round aims at the budget itself, so only its own rounding remains.
      EXPECT_NEAR(AfterAllRounds(plan, start), double(plan.max_vertices), 1.0);
      EXPECT_NEAR(RoundGrowth(plan, 0, start), factor, 1e-4);
    }
  }
}

TEST(RoundGrowth, IsCappedWhereTheBudgetIsFar) {
  const GrowthPlan plan{5, 1000000000};
  EXPECT_EQ(RoundGrowth(plan, 0, 1000), 2.5);
  // Each round rounds up by half a vertex or less, which later rounds multiply: below 1 %.
  EXPECT_NEAR(AfterAllRounds(plan, 1000), 1000 * std::pow(2.5, 5), 1000);
}

TEST(RoundGrowth, CatchesUpAfterARoundThatGrewLess) {
  const GrowthPlan plan{5, 32000};
  EXPECT_GT(RoundGrowth(plan, 1, 1000), RoundGrowth(plan, 1, 2000));
  EXPECT_DOUBLE_EQ(RoundGrowth(plan, 4, 20000), 1.6);
}

TEST(RoundGrowth, IsOneWhereTheBudgetIsSpent) {
  EXPECT_EQ(RoundGrowth({5, 1000}, 2, 1000), 1.0);
  EXPECT_EQ(RoundGrowth({5, 10}, 2, 1000), 1.0);
  EXPECT_EQ(RoundGrowth({5, 1500}, 99, 1000), 1.5);  // after the last round
}

TEST(AffordableVertices, GrowsWithTimeUpToAVertexForSixteenPixels) {
  for (const uint64_t pixels : {uint64_t{8000}, uint64_t{4000000}, uint64_t{100000000}}) {
    uint64_t before = 0;
    for (double seconds = 1; seconds < 1e9; seconds *= 2) {
      const uint64_t vertices = AffordableVertices(seconds, pixels);
      EXPECT_LE(vertices, pixels / 16);
      if (before < pixels / 16) {
        EXPECT_GT(vertices, before);
      }
      before = vertices;
    }
    EXPECT_EQ(before, pixels / 16);
  }
}

TEST(AffordableVertices, IsTheSameForEveryPictureSizeWhereTimeIsShort) {
  EXPECT_EQ(AffordableVertices(10, 100000000), AffordableVertices(10, 200000000));
  EXPECT_EQ(AffordableVertices(120, 100000000), 110000u);  // as measured
}

}  // namespace
}  // namespace tetrec
