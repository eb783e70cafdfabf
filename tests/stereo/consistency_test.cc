#include "stereo/consistency.h"

#include "geometry/look_at.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

const Camera kCamera{40, 30, 50, 50, 20, 15};

// Cameras around (0, 0, 3) that look at the plane z = 0, and their true depths.
struct PlaneScene {
  std::vector<StereoView> views;
  std::vector<StereoDepth> maps;
  std::vector<std::vector<uint32_t>> others;
};

PlaneScene MakePlaneScene(uint32_t count) {
  PlaneScene scene;
  for (uint32_t i = 0; i < count; ++i) {
    StereoView view;
    view.view = i;
    view.camera = kCamera;
    view.cam_from_world =
        CamLookingAt({0.3 * i, 0.1 * i, 3}, {0.05 * i, 0, 0}, glm::dvec3(0, 1, 0));
    const Rigid3 world_from_cam = view.cam_from_world.Inverse();
    StereoDepth map = MakeStereoDepth(i, kCamera);
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) {
        const glm::dvec3 ray = world_from_cam.rotation * kCamera.CamFromImage({x + 0.5, y + 0.5});
        map.depth[map.Index(x, y)] = float(-world_from_cam.translation.z / ray.z);
      }
    }
    scene.views.push_back(view);
    scene.maps.push_back(map);
    scene.others.emplace_back();
    for (uint32_t j = 0; j < count; ++j) {
      if (j != i) scene.others.back().push_back(j);
    }
  }
  return scene;
}

TEST(CountAgreement, OfTrueDepthsIsTheNumberOfViewsThatSeeThePoint) {
  const PlaneScene scene = MakePlaneScene(3);
  const auto counted = CountAgreement(scene.maps, scene.views, scene.others, 0.02);
  const size_t middle = counted[0].Index(20, 15);
  EXPECT_EQ(counted[0].agreement[middle], 2);
  // A pixel of another view is up to half a pixel away: the plane is nearly parallel to the image.
  EXPECT_NEAR(counted[0].depth[middle], scene.maps[0].depth[middle], 0.02);
}

TEST(CountAgreement, LeavesAWrongMapAlone) {
  PlaneScene scene = MakePlaneScene(4);
  for (float& depth : scene.maps[2].depth) depth *= 1.1f;
  const auto counted = CountAgreement(scene.maps, scene.views, scene.others, 0.02);
  for (const uint8_t agreement : counted[2].agreement) EXPECT_EQ(agreement, 0);
  EXPECT_EQ(counted[1].agreement[counted[1].Index(20, 15)], 2) << "the other two";
  StereoDepth wrong = counted[2], right = counted[1];
  EXPECT_EQ(KeepConfirmed(wrong, 1, 1, 0.03), 0u);
  EXPECT_GT(KeepConfirmed(right, 1, 1, 0.03), 600u);
}

TEST(CountAgreement, MovesADepthToTheMeanOfThoseThatAgree) {
  PlaneScene scene = MakePlaneScene(3);
  for (float& depth : scene.maps[0].depth) depth *= 1.006f;
  const auto counted = CountAgreement(scene.maps, scene.views, scene.others, 0.02);
  const size_t middle = counted[0].Index(20, 15);
  const double wrong = scene.maps[0].depth[middle];
  EXPECT_NEAR(counted[0].depth[middle] / (wrong / 1.006), 1.002, 0.002);
}

// A map of 8 x 4 pixels with the given depths, which so many other views confirm.
StereoDepth MapOf(const std::vector<float>& depths, uint8_t agreement) {
  StereoDepth map = MakeStereoDepth(0, {8, 4, 10, 10, 4, 2});
  map.depth = depths;
  for (size_t i = 0; i < depths.size(); ++i) map.agreement[i] = depths[i] > 0 ? agreement : 0;
  return map;
}

TEST(ViewsToConfirm, AreTwoWhereTwoConfirmHalfOfTheDepths) {
  std::vector<float> depths(32, 0.0f);
  std::fill_n(depths.begin(), 10, 2.0f);
  std::vector<StereoDepth> maps(2, MapOf(depths, 1));
  EXPECT_EQ(ViewsToConfirm(maps), 1);
  for (size_t i = 0; i < 9; ++i) maps[0].agreement[i] = 3;
  EXPECT_EQ(ViewsToConfirm(maps), 1);
  maps[1].agreement[0] = 2;
  EXPECT_EQ(ViewsToConfirm(maps), 2) << "10 of 20";
}

TEST(KeepConfirmed, KeepsPatchesWithEnoughEvidence) {
  const std::vector<float> depths = {2, 2, 0, 0, 0, 0, 0, 3,  //
                                     0, 0, 2, 0, 0, 0, 0, 0,  //
                                     0, 2, 0, 0, 0, 0, 0, 5,  //
                                     0, 0, 0, 0, 0, 0, 5, 0};
  StereoDepth map = MapOf(depths, 2);
  EXPECT_EQ(KeepConfirmed(map, 1, 4, 0.03), 7u) << "even a pixel that two views confirm";
  EXPECT_EQ(map.depth, depths);
  EXPECT_EQ(KeepConfirmed(map, 1, 16, 0.03), 4u) << "corners touch";
  const StereoDepth kept = MapOf({2, 2, 0, 0, 0, 0, 0, 0,  //
                                  0, 0, 2, 0, 0, 0, 0, 0,  //
                                  0, 2, 0, 0, 0, 0, 0, 0,  //
                                  0, 0, 0, 0, 0, 0, 0, 0},
                                 2);
  EXPECT_EQ(map.depth, kept.depth);
  EXPECT_EQ(map.agreement, kept.agreement);
  StereoDepth by_one = MapOf(depths, 1);
  EXPECT_EQ(KeepConfirmed(by_one, 1, 4, 0.03), 4u);
  EXPECT_EQ(KeepConfirmed(by_one, 1, 5, 0.03), 0u);
}

TEST(KeepConfirmed, AddsTheEvidenceOfAMixedPatch) {
  std::vector<float> depths(32, 0.0f);
  for (const size_t i : {7u, 14u, 15u}) depths[i] = 2;
  StereoDepth map = MapOf(depths, 1);
  map.agreement[14] = 3;
  StereoDepth rejected = map;
  EXPECT_EQ(KeepConfirmed(map, 1, 11, 0.03), 3u) << "1 + 9 + 1";
  EXPECT_EQ(KeepConfirmed(rejected, 1, 12, 0.03), 0u);
}

TEST(KeepConfirmed, DoesNotJoinTheEndOfARowWithTheNextRow) {
  std::vector<float> depths(32, 0.0f);
  depths[7] = depths[8] = 2;
  StereoDepth map = MapOf(depths, 1);
  EXPECT_EQ(KeepConfirmed(map, 1, 2, 0.03), 0u);
}

TEST(KeepConfirmed, KeepsTheSameOfAMirroredMap) {
  std::vector<float> depths(32, 0.0f);
  for (size_t x = 0; x < 4; ++x) depths[x] = float(2 + 0.061 * double(x));  // 2.961 to 3.05 %
  for (const double tolerance : {0.0295, 0.0299, 0.0303}) {
    StereoDepth map = MapOf(depths, 1);
    StereoDepth mirrored = MapOf({depths.rbegin(), depths.rend()}, 1);
    EXPECT_EQ(KeepConfirmed(map, 1, 2, tolerance), KeepConfirmed(mirrored, 1, 2, tolerance));
  }
}

TEST(KeepConfirmed, LeavesOutWhatTooFewOtherViewsConfirm) {
  StereoDepth map = MapOf(std::vector<float>(32, 2.0f), 2);
  for (const size_t i : {0u, 9u, 31u}) map.agreement[i] = 0;
  map.agreement[30] = 1;
  EXPECT_EQ(KeepConfirmed(map, 1, 1, 0.03), 29u);
  for (const size_t i : {0u, 9u, 31u}) EXPECT_EQ(map.depth[i], 0);
  EXPECT_EQ(KeepConfirmed(map, 2, 1, 0.03), 28u);
  EXPECT_EQ(map.depth[30], 0);
}

TEST(KeepConfirmed, FollowsASurfaceButNotAcrossAStep) {
  std::vector<float> depths = {2.00f, 2.04f, 2.08f, 2.12f, 3.00f, 3.00f};
  depths.resize(32, 0.0f);
  StereoDepth map = MapOf(depths, 1);
  EXPECT_EQ(KeepConfirmed(map, 1, 2, 0.03), 6u);
  EXPECT_EQ(map.depth, depths);
  EXPECT_EQ(KeepConfirmed(map, 1, 3, 0.03), 4u);
  EXPECT_EQ(map.depth[3], 2.12f);
  EXPECT_EQ(map.depth[4], 0);
}

}  // namespace
}  // namespace tetrec
