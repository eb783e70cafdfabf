#include "surface/confirmed_depths.h"

#include "surface/depth_between.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetrec {
namespace {

constexpr Camera kCamera{8, 6, 10.0, 10.0, 4.0, 3.0};

DepthMap MapOf(float depth) {
  DepthMap map = MakeDepthMap(kCamera.width, kCamera.height);
  std::ranges::fill(map.depth, depth);
  return map;
}

// Of half of the camera's resolution.
StereoDepth ConfirmedMapOf(float depth) {
  StereoDepth map = MakeStereoDepth(0, {4, 3, 5.0, 5.0, 2.0, 1.5});
  std::ranges::fill(map.depth, depth);
  std::ranges::fill(map.agreement, kLeastAgreement);
  return map;
}

// The depth at a pixel amid the image.
float DepthWith(const StereoDepth& map, float first, float last) {
  DepthMap stopped = MapOf(first);
  UseConfirmedDepths(kCamera, map, {MapOf(first), MapOf(last)}, stopped);
  return stopped.At(4, 3);
}

TEST(DepthBetween, IsBilinearOnOneSurfaceAndNothingElsewhere) {
  EXPECT_NEAR(DepthBetween({1, 2, 3, 4}, {0.5, 0.25}, 3.5).value_or(0), 2.0, 1e-12);
  EXPECT_FALSE(DepthBetween({1, 2, 3, 4}, {0.5, 0.25}, 3));
  EXPECT_FALSE(DepthBetween({1, 2, double(kNoDepth), 2}, {0.5, 0.5}, 9));
}

TEST(UseConfirmedDepths, TakesThoseWithinTheStretchInWhichARayLosesItsLight) {
  EXPECT_FLOAT_EQ(DepthWith(ConfirmedMapOf(2.0f), 1.8f, 2.5f), 2.0f);
  EXPECT_FLOAT_EQ(DepthWith(ConfirmedMapOf(2.0f), 1.8f, kNoDepth), 2.0f);  // to infinity
  EXPECT_FLOAT_EQ(DepthWith(ConfirmedMapOf(2.0f), 2.01f, 2.5f), 2.0f);     // just before it
  EXPECT_FLOAT_EQ(DepthWith(ConfirmedMapOf(2.0f), 2.2f, 2.5f), 2.2f);
  EXPECT_FLOAT_EQ(DepthWith(ConfirmedMapOf(2.0f), 1.5f, 1.9f), 1.5f);
  EXPECT_EQ(DepthWith(ConfirmedMapOf(2.0f), kNoDepth, kNoDepth), kNoDepth);
}

TEST(UseConfirmedDepths, TakesNoneThatTooFewViewsConfirm) {
  StereoDepth map = ConfirmedMapOf(2.0f);
  map.agreement[map.Index(2, 1)] = kLeastAgreement - 1;
  EXPECT_FLOAT_EQ(DepthWith(map, 1.8f, 2.5f), 1.8f);
}

TEST(UseConfirmedDepths, TakesNoneBetweenTwoSurfaces) {
  StereoDepth map = ConfirmedMapOf(2.0f);
  for (int y = 0; y < 3; ++y) map.depth[map.Index(3, y)] = 9.0f;
  DepthMap stopped = MapOf(1.0f);
  UseConfirmedDepths(kCamera, map, {MapOf(1.0f), MapOf(10.0f)}, stopped);
  EXPECT_FLOAT_EQ(stopped.At(6, 2), 1.0f);
  EXPECT_FLOAT_EQ(stopped.At(3, 2), 2.0f);
}

TEST(UseConfirmedDepths, IsLinearOnASurfaceAndCountsWhatItReplaced) {
  StereoDepth map = ConfirmedMapOf(2.0f);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) map.depth[map.Index(x, y)] = 2.0f + 0.1f * (float(x) + 0.5f);
  }
  DepthMap stopped = MapOf(1.8f);
  // The pixels within half a pixel of the map's border are not between four of its pixels.
  EXPECT_EQ(UseConfirmedDepths(kCamera, map, {MapOf(1.8f), MapOf(2.5f)}, stopped), 6u * 4u);
  EXPECT_FLOAT_EQ(stopped.At(3, 2), 2.0f + 0.1f * 0.5f * 3.5f);
  EXPECT_FLOAT_EQ(stopped.At(0, 0), 1.8f);
}

}  // namespace
}  // namespace tetrec
