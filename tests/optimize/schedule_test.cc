#include "optimize/schedule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

TEST(RateShare, FallsFromOne) {
  const ScheduleOptions options;
  EXPECT_EQ(RateShare(options, AtProgress(0.0), 0), 1.0);
  for (const uint64_t steps : {100u, 5000u, 1000000u}) {
    double before = 1.0;
    for (uint64_t i = 1; i <= 100; ++i) {
      const double share = RateShare(options, AtProgress(double(i) / 100.0), steps * i / 100);
      EXPECT_LT(share, before);
      before = share;
    }
    EXPECT_GT(before, 0.0);
  }
}

TEST(RateShare, IsTheSameInEveryRunThatLastsLonger) {
  const ScheduleOptions options;
  EXPECT_EQ(RateShare(options, {0.7, 0.7}, 2000), RateShare(options, {0.1, 0.7}, 2000));
}

TEST(RateShare, FallsFastAtTheEnd) {
  const ScheduleOptions options;
  const double before = RateShare(options, AtProgress(0.75), 4000);
  EXPECT_DOUBLE_EQ(before, 10 * RateShare(options, AtProgress(1.0), 4000));
  EXPECT_NEAR(RateShare(options, AtProgress(0.875), 4000), 0.55 * before, 1e-12);
}

TEST(RateShare, OfALongRunFallsByHalfAtTheEndOfItsGrowth) {
  const ScheduleOptions options;
  const double before = RateShare(options, {0.15, 0.75}, 4000);
  EXPECT_DOUBLE_EQ(before, RateShare(options, {0.05, 0.25}, 4000));
  EXPECT_NEAR(RateShare(options, {0.175, 0.875}, 4000), 0.75 * before, 1e-12);
  EXPECT_NEAR(RateShare(options, {0.2, 1.0}, 4000), 0.5 * before, 1e-12);
  EXPECT_NEAR(RateShare(options, {0.7, 3.5}, 4000), 0.5 * before, 1e-12);
  EXPECT_NEAR(RateShare(options, {1.0, 5.0}, 4000), 0.1 * before, 1e-12);
}

TEST(RateShare, FallsExponentiallyToAGivenShare) {
  for (const double last : {1.0, 0.3, 0.05, 0.001}) {
    ScheduleOptions options;
    options.final_rate_share = last;
    EXPECT_EQ(RateShare(options, AtProgress(0.0), 1000), 1.0);
    EXPECT_DOUBLE_EQ(RateShare(options, AtProgress(1.0), 1000), last);
    EXPECT_DOUBLE_EQ(RateShare(options, AtProgress(0.5), 1000),
                     std::sqrt(last));  // the geometric mean
  }
}

TEST(RateShare, StaysAtItsEndsOutsideTheRun) {
  const ScheduleOptions options;
  EXPECT_EQ(RateShare(options, AtProgress(-0.5), 1000), RateShare(options, AtProgress(0.0), 1000));
  EXPECT_EQ(RateShare(options, AtProgress(1.5), 1000), RateShare(options, AtProgress(1.0), 1000));
}

TEST(PlanGrowth, HasMoreRoundsWhereThereIsMoreToGrow) {
  const ScheduleOptions options;
  EXPECT_EQ(PlanGrowth(options, 1000, 1000, 1000, 1.0).size(), 3u);
  EXPECT_EQ(PlanGrowth(options, 1000, 500, 500, 1.0).size(), 3u);
  EXPECT_EQ(PlanGrowth(options, 1000, 4000, 4000, 1.0).size(), 5u);
  EXPECT_EQ(PlanGrowth(options, 10, 1000000000, 1000000000, 1.0).size(), 9u);
}

TEST(PlanGrowth, HasLateRoundsWhereNoMoreVerticesAreAffordable) {
  const size_t early = PlanGrowth({}, 70000, 110000, 110000, 1.0).size();
  for (const auto& [length, late] : {std::pair(1.2, 0u), {2.5, 1u}, {5.0, 2u}, {30.0, 4u}}) {
    const std::vector<PlannedRound> plan = PlanGrowth({}, 70000, 110000, 110000, length);
    ASSERT_EQ(plan.size(), early + late) << length;
    for (size_t i = early; i < plan.size(); ++i) {
      EXPECT_TRUE(plan[i].is_late);
      EXPECT_EQ(plan[i].vertices, 110000u);
    }
  }
}

// A round by a few hundredths would not be worth its trial.
TEST(PlanGrowth, HasNoLateRoundsWhereHardlyMoreVerticesAreAffordable) {
  const size_t early = PlanGrowth({}, 70000, 110000, 110000, 1.0).size();
  EXPECT_EQ(PlanGrowth({}, 70000, 110000, 113000, 1.1).size(), early);
  EXPECT_EQ(PlanGrowth({}, 70000, 110000, 116000, 1.2).size(), early + 1);
}

TEST(PlanGrowth, LeadsToTheBudgetByEqualFactors) {
  const std::vector<PlannedRound> plan = PlanGrowth({}, 1000, 4000, 4000, 1.0);
  uint64_t before = 1000;
  for (const PlannedRound& round : plan) {
    EXPECT_NEAR(double(round.vertices) / double(before), std::pow(4.0, 0.2), 2e-3);
    before = round.vertices;
  }
  EXPECT_EQ(before, 4000u);
}

TEST(PlanGrowth, BeginsWithRoundsThatFollowEachOtherQuickly) {
  const ScheduleOptions options;
  double before = 0.0, gap_before = 0.0;
  for (const PlannedRound& round : PlanGrowth(options, 1000, 8000, 8000, 1.0)) {
    EXPECT_GT(round.due - before, gap_before);
    gap_before = round.due - before;
    before = round.due;
  }
  EXPECT_DOUBLE_EQ(before, options.last_round);
}

TEST(PlanGrowth, OfALongRunBeginsWithThatOfAShortOne) {
  const ScheduleOptions options;
  const std::vector<PlannedRound> brief = PlanGrowth(options, 1000, 4000, 4000, 1.0);
  const std::vector<PlannedRound> plan = PlanGrowth(options, 1000, 4000, 7000, 5.0);
  ASSERT_EQ(plan.size(), brief.size() + 2);
  for (size_t i = 0; i < brief.size(); ++i) {
    EXPECT_EQ(plan[i].due, brief[i].due);
    EXPECT_EQ(plan[i].vertices, brief[i].vertices);
    EXPECT_FALSE(plan[i].is_late);
  }
  EXPECT_NEAR(plan[5].due, options.last_round * std::sqrt(5.0), 1e-12);
  EXPECT_NEAR(plan[6].due, options.last_round * 5.0, 1e-12);
  EXPECT_EQ(plan[6].vertices, 7000u);
  EXPECT_TRUE(plan[5].is_late && plan[6].is_late);
}

TEST(PlanGrowth, SpreadsAGivenNumberOfRoundsOverTheRun) {
  ScheduleOptions options;
  for (const int rounds : {0, 1, 40}) {
    options.rounds = rounds;
    const std::vector<PlannedRound> plan = PlanGrowth(options, 1000, 4000, 9000, 5.0);
    ASSERT_EQ(plan.size(), size_t(rounds));
    if (rounds == 0) continue;
    EXPECT_NEAR(plan.back().due, options.last_round * 5.0, 1e-12);
    EXPECT_EQ(plan.back().vertices, 9000u);
  }
}

TEST(RoundGrowth, LeadsToThePlannedVerticesWithinBounds) {
  EXPECT_DOUBLE_EQ(RoundGrowth({0.5, 1500}, 1000), 1.5);
  EXPECT_EQ(RoundGrowth({0.5, 1000000}, 1000), 2.5);
  EXPECT_EQ(RoundGrowth({0.5, 10}, 1000), 1.0);
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
