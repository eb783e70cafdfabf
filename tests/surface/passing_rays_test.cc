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

Mended MendedAt(float first, float second, float level) {
  SeenDepth view{kCamera, {}, MapOf(level), {}};
  const PassingRays passing =
      MendPassingRays(kBounds, {MapOf(first), MapOf(second), MapOf(level)}, view);
  return {passing, view.depth.At(4, 3), view.free_until.At(4, 3)};
}

TEST(MendPassingRays, StopsThemAtAWallThatLetsLightThrough) {
  for (const float level : {2.2f, 40.0f, kNoDepth}) {
    const Mended mended = MendedAt(2.0f, 2.05f, level);
    EXPECT_FLOAT_EQ(mended.depth, 2.05f);
    EXPECT_EQ(mended.free_until, kNoDepth);
    EXPECT_EQ(mended.passing.stopped, 48u);
    EXPECT_EQ(mended.passing.open, 0u);
  }
}

TEST(MendPassingRays, KnowsOnlyWhatIsBeforeHazeOrAFaintWall) {
  for (const float second : {2.2f, 40.0f, kNoDepth}) {
    const Mended mended = MendedAt(2.0f, second, 40.0f);
    EXPECT_FLOAT_EQ(mended.depth, 40.0f);
    EXPECT_FLOAT_EQ(mended.free_until, 2.0f);
    EXPECT_EQ(mended.passing.stopped, 0u);
    EXPECT_EQ(mended.passing.open, 48u);
  }
}

TEST(MendPassingRays, LeavesThoseThatAreStoppedInsideOrLoseNothingThere) {
  const Mended at_wall = MendedAt(2.0f, 2.05f, 2.1f), behind_haze = MendedAt(2.0f, 3.0f, 4.0f),
               outside = MendedAt(39.0f, 39.5f, 40.0f),
               free = MendedAt(kNoDepth, kNoDepth, kNoDepth);
  EXPECT_FLOAT_EQ(at_wall.depth, 2.1f);
  EXPECT_FLOAT_EQ(behind_haze.depth, 4.0f);
  EXPECT_FLOAT_EQ(outside.depth, 40.0f);
  EXPECT_EQ(free.depth, kNoDepth);
  for (const Mended& mended : {at_wall, behind_haze, outside, free}) {
    EXPECT_EQ(mended.free_until, kNoDepth);
    EXPECT_EQ(mended.passing.stopped + mended.passing.open, 0u);
  }
}

TEST(MendPassingRays, LeavesDepthsThatAreKnownBetter) {
  SeenDepth view{kCamera, {}, MapOf(3.0f), {}};
  MendPassingRays(kBounds, {MapOf(2.0f), MapOf(2.05f), MapOf(40.0f)}, view);
  EXPECT_FLOAT_EQ(view.depth.At(4, 3), 3.0f);
  EXPECT_EQ(view.free_until.At(4, 3), kNoDepth);
}

}  // namespace
}  // namespace tetrec
