#include "surface/passing_rays.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetrec {
namespace {

constexpr Camera kCamera{8, 6, 10.0, 10.0, 4.0, 3.0};
// Around the camera, which is at the origin of the world and looks along z.
const Bounds3 kBounds{glm::dvec3(-5), glm::dvec3(5)};

DepthMap MapOf(float depth) {
  DepthMap map = MakeDepthMap(kCamera.width, kCamera.height);
  std::ranges::fill(map.depth, depth);
  return map;
}

struct Mended {
  PassingRays passing;
  float depth, free_until;  // at a pixel amid the image
};

// Rays that have lost a little of their light at `first`, more at `second`, and most at `stopped`.
Mended MendedAt(float first, float second, float stopped) {
  SeenDepth view{kCamera, {}, MapOf(stopped), {}};
  const PassingRays passing = MendPassingRays(kBounds, MapOf(first), MapOf(second), view);
  return {passing, view.depth.At(4, 3), view.free_until.At(4, 3)};
}

TEST(MendPassingRays, StopsThemAtAWallThatLetsLightThrough) {
  for (const float stopped : {40.0f, kNoDepth}) {
    const Mended mended = MendedAt(2.0f, 2.05f, stopped);
    EXPECT_FLOAT_EQ(mended.depth, 2.05f);
    EXPECT_EQ(mended.free_until, kNoDepth);
    EXPECT_EQ(mended.passing.all, 48u);
    EXPECT_EQ(mended.passing.stopped, 48u);
  }
}

TEST(MendPassingRays, KnowsOnlyWhatIsBeforeHazeOrAFaintWall) {
  for (const float second : {2.2f, 40.0f, kNoDepth}) {
    const Mended mended = MendedAt(2.0f, second, 40.0f);
    EXPECT_FLOAT_EQ(mended.depth, 40.0f);
    EXPECT_FLOAT_EQ(mended.free_until, 2.0f);
    EXPECT_EQ(mended.passing.all, 48u);
    EXPECT_EQ(mended.passing.stopped, 0u);
  }
}

TEST(MendPassingRays, LeavesThoseThatAreStoppedInsideOrLoseNothingThere) {
  const Mended inside = MendedAt(2.0f, 2.05f, 4.0f), outside = MendedAt(39.0f, 39.5f, 40.0f),
               free = MendedAt(kNoDepth, kNoDepth, kNoDepth);
  EXPECT_FLOAT_EQ(inside.depth, 4.0f);
  EXPECT_FLOAT_EQ(outside.depth, 40.0f);
  EXPECT_EQ(free.depth, kNoDepth);
  for (const Mended& mended : {inside, outside, free}) {
    EXPECT_EQ(mended.free_until, kNoDepth);
    EXPECT_EQ(mended.passing.all, 0u);
  }
}

}  // namespace
}  // namespace tetrec
