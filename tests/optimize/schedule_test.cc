#include "optimize/schedule.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

TEST(RateShare, FallsFromOneToTheFinalShare) {
  for (const double last : {1.0, 0.3, 0.05, 0.001}) {
    ScheduleOptions options;
    options.final_rate_share = last;
    EXPECT_EQ(RateShare(options, 0.0), 1.0);
    EXPECT_DOUBLE_EQ(RateShare(options, 1.0), last);
    EXPECT_DOUBLE_EQ(RateShare(options, 0.5), std::sqrt(last));  // exponential: geometric mean
    double before = 1.0;
    for (int i = 1; i <= 100; ++i) {
      const double share = RateShare(options, i / 100.0);
      EXPECT_LE(share, before);
      before = share;
    }
  }
}

TEST(RateShare, StaysAtItsEndsOutsideTheRun) {
  const ScheduleOptions options;
  EXPECT_EQ(RateShare(options, -0.5), 1.0);
  EXPECT_EQ(RateShare(options, 1.5), RateShare(options, 1.0));
}

TEST(RoundProgress, RisesToTheLastRound) {
  for (const int rounds : {1, 2, 5, 12}) {
    ScheduleOptions options;
    options.rounds = rounds;
    double before = 0.0, gap_before = 0.0;
    for (int round = 0; round < rounds; ++round) {
      const double progress = RoundProgress(options, round);
      EXPECT_GT(progress, before);
      EXPECT_GT(progress - before, gap_before) << "the first rounds come soon after one another";
      gap_before = progress - before;
      before = progress;
    }
    EXPECT_DOUBLE_EQ(before, options.last_round);
  }
}

// Vertices after all rounds, if each round grows as much as it may.
double AfterAllRounds(const ScheduleOptions& options, uint64_t start, uint64_t max_vertices) {
  uint64_t vertices = start;
  for (int round = 0; round < options.rounds; ++round) {
    const double growth = RoundGrowth(options, round, vertices, max_vertices);
    EXPECT_GE(growth, 1.0);
    EXPECT_LE(growth, 2.5);
    vertices = uint64_t(std::llround(double(vertices) * growth));
  }
  return double(vertices);
}

TEST(RoundGrowth, LeadsToTheBudget) {
  for (const int rounds : {1, 3, 5, 8}) {
    ScheduleOptions options;
    options.rounds = rounds;
    for (const double factor : {1.0, 1.3, 2.0, 2.4}) {
      const uint64_t start = 10000;
      const double budget = std::floor(double(start) * std::pow(factor, rounds));
      // The last round aims at the budget itself, so only its own rounding remains.
      EXPECT_NEAR(AfterAllRounds(options, start, uint64_t(budget)), budget, 1.0);
      EXPECT_NEAR(RoundGrowth(options, 0, start, uint64_t(budget)), factor, 1e-4);
    }
  }
}

TEST(RoundGrowth, IsCappedWhereTheBudgetIsFar) {
  const ScheduleOptions options;
  EXPECT_EQ(RoundGrowth(options, 0, 1000, 1000000000), 2.5);
  // Each round rounds up by half a vertex or less, which later rounds multiply: below 1 %.
  EXPECT_NEAR(AfterAllRounds(options, 1000, 1000000000), 1000 * std::pow(2.5, 5), 1000);
}

TEST(RoundGrowth, CatchesUpAfterARoundThatGrewLess) {
  const ScheduleOptions options;
  EXPECT_GT(RoundGrowth(options, 1, 1000, 32000), RoundGrowth(options, 1, 2000, 32000));
  EXPECT_DOUBLE_EQ(RoundGrowth(options, 4, 20000, 32000), 1.6);
}

TEST(RoundGrowth, IsOneWhereTheBudgetIsSpent) {
  const ScheduleOptions options;
  EXPECT_EQ(RoundGrowth(options, 2, 1000, 1000), 1.0);
  EXPECT_EQ(RoundGrowth(options, 2, 1000, 10), 1.0);
  EXPECT_EQ(RoundGrowth(options, 99, 1000, 1500), 1.5);  // after the last round
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
  EXPECT_EQ(AffordableVertices(120, 100000000), 180000u);  // as measured
}

}  // namespace
}  // namespace tetrec
