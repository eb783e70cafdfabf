// What a run affords, by its limits and the device.
#include "optimize/run_length.h"

#include "optimize/mesh_budget.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetrec {
namespace {

constexpr uint64_t kSubjectPixels = 10'000'000;
constexpr DevicePace kCores{};
constexpr DevicePace kFast = {.rays_per_step = 65536, .speed = 10};

OptimizeOptions Limited(double seconds, uint64_t iterations) {
  OptimizeOptions options;
  options.time_limit_s = seconds;
  options.iterations = iterations;
  return options;
}

uint64_t VerticesOf(const OptimizeOptions& options, const DevicePace& pace) {
  return MaxVertices(options, LengthOf(options, pace, kSubjectPixels, kNoBudget), kSubjectPixels,
                     kNoBudget);
}

TEST(RunLength, IsThatOfTheLimitThatIsReachedFirst) {
  EXPECT_EQ(LengthOf(Limited(300, 0), kCores, kSubjectPixels, kNoBudget).seconds, 300);
  EXPECT_EQ(LengthOf(Limited(0, 4000), kCores, kSubjectPixels, kNoBudget).seconds,
            4000 / kStepsPerSecond);
  EXPECT_EQ(LengthOf(Limited(300, 4000), kCores, kSubjectPixels, kNoBudget).seconds,
            4000 / kStepsPerSecond);
  EXPECT_EQ(LengthOf(Limited(30, 4000), kCores, kSubjectPixels, kNoBudget).seconds, 30);
}

// An almost equal limit of the other kind makes no difference.
TEST(RunLength, AffordsNoMoreWithASecondLimit) {
  for (const DevicePace& pace : {kCores, kFast}) {
    for (const uint64_t iterations : {500u, 11'999u, 12'001u, 1'000'000u}) {
      const uint64_t both = VerticesOf(Limited(300, iterations), pace);
      EXPECT_EQ(both, std::min(VerticesOf(Limited(300, 0), pace),
                               VerticesOf(Limited(0, iterations), pace)));
    }
  }
}

TEST(RunLength, WithoutLimitsIsThatOfAFullyGrownMesh) {
  for (const DevicePace& pace : {kCores, kFast}) {
    EXPECT_NEAR(double(VerticesOf(Limited(0, 0), pace)), kSubjectPixels / kPixelsPerVertex, 1);
  }
  OptimizeOptions small_steps = Limited(0, 0);
  small_steps.rays_per_step = 4096;
  EXPECT_EQ(LengthOf(small_steps, kFast, kSubjectPixels, kNoBudget).seconds,
            LengthOf(Limited(0, 0), kCores, kSubjectPixels, kNoBudget).seconds);
}

TEST(RunLength, OnAFastDeviceAffordsWhatALongerOneDoes) {
  EXPECT_EQ(VerticesOf(Limited(60, 0), kFast), VerticesOf(Limited(600, 0), kCores));
  EXPECT_GT(VerticesOf(Limited(60, 0), kFast), VerticesOf(Limited(60, 0), kCores));
}

// By iterations alone, a run is as long on every device; only its steps may be larger.
TEST(RunLength, ByIterationsAffordsByItsRays) {
  OptimizeOptions options = Limited(0, 4000);
  options.rays_per_step = 4096;
  EXPECT_EQ(VerticesOf(options, kFast), VerticesOf(Limited(0, 4000), kCores));
  options.rays_per_step = 65536;
  EXPECT_EQ(VerticesOf(options, kCores), VerticesOf(Limited(0, 4000), kFast));
  EXPECT_EQ(VerticesOf(options, kCores), VerticesOf(Limited(0, 16 * 4000), kCores));
}

TEST(RunLength, IsTheSameOnEveryDeviceIfDeterministic) {
  OptimizeOptions options = Limited(0, 4000);
  options.renderer.deterministic = true;
  EXPECT_EQ(VerticesOf(options, kFast), VerticesOf(options, kCores));
}

TEST(RunLength, NeverAffordsMoreThanTheBudget) {
  const OptimizeOptions options = Limited(300, 0);
  const RunLength length = LengthOf(options, kFast, kSubjectPixels, kNoBudget);
  EXPECT_LE(double(MaxVertices(options, length, kSubjectPixels, 65'000)), 65'000 / kTetsPerVertex);
}

// Else its last rounds would come long after the mesh has reached the budget.
TEST(RunLength, WithoutLimitsIsThatOfAMeshWithinTheBudget) {
  const OptimizeOptions options = Limited(0, 0);
  EXPECT_EQ(LengthOf(options, kCores, kSubjectPixels, 650'000).seconds,
            SecondsForVertices(650'000 / kTetsPerVertex));
  EXPECT_EQ(LengthOf(options, kCores, kSubjectPixels, 65'000'000).seconds,
            LengthOf(options, kCores, kSubjectPixels, kNoBudget).seconds);
}

// Growth ends at kGrowthSeconds, later rounds lead on to what the whole run affords.
TEST(RunLength, RoundsGrowAsFarAsTheDeviceAffordsInTheirTime) {
  const OptimizeOptions options = Limited(600, 0);
  for (const DevicePace& pace : {kCores, kFast}) {
    const RunLength length = LengthOf(options, pace, kSubjectPixels, kNoBudget);
    const uint64_t most = MaxVertices(options, length, kSubjectPixels, kNoBudget);
    const std::vector<PlannedRound> plan =
        PlanRounds(options, length, 10'000, most, kSubjectPixels);
    uint64_t of_growth = 0;
    for (const PlannedRound& round : plan) {
      if (!round.is_late) of_growth = round.vertices;
    }
    EXPECT_NEAR(double(of_growth), double(VerticesOf(Limited(kGrowthSeconds, 0), pace)), 1);
    EXPECT_NEAR(double(plan.back().vertices), double(most), 1);
    EXPECT_TRUE(plan.back().is_late);
  }
}

}  // namespace
}  // namespace tetrec
