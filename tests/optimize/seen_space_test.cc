#include "optimize/seen_space.h"

#include "core/error.h"
#include "expect_error.h"
#include "optimize/ring_scene.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

// Cameras in a row that look along z at a wall at z = 4.
Scene ViewsOfAWall(int cameras) {
  Scene scene;
  scene.cameras = {{64, 48, 64, 64, 32, 24}};
  for (int i = 0; i < cameras; ++i) {
    View view;
    view.cam_from_world.translation = {-0.01 * i, 0.0, 0.0};
    scene.views.push_back(view);
  }
  return scene;
}

// `wall`: the depth that it shows everywhere.
StereoDepth MapOf(const Scene& scene, uint32_t view, float wall, uint8_t agreement = 2) {
  StereoDepth map = MakeStereoDepth(view, scene.cameras[0]);
  std::fill(map.depth.begin(), map.depth.end(), wall);
  std::fill(map.agreement.begin(), map.agreement.end(), agreement);
  return map;
}

bool IsEmpty(const SeenSpace& space, const glm::vec3& point) {
  return space.Contains(std::vector<glm::vec3>{point})[0] != 0;
}

TEST(SeenSpace, IsInFrontOfWhatTwoMapsShow) {
  const Scene scene = ViewsOfAWall(3);
  const std::vector<StereoDepth> maps = {MapOf(scene, 0, 4.0f), MapOf(scene, 1, 4.0f)};
  const SeenSpace space(scene, maps);
  EXPECT_TRUE(IsEmpty(space, {0.0f, 0.0f, 2.0f}));
  EXPECT_TRUE(IsEmpty(space, {0.0f, 0.0f, 3.7f}));
  EXPECT_FALSE(IsEmpty(space, {0.0f, 0.0f, 3.9f})) << "at the wall";
  EXPECT_FALSE(IsEmpty(space, {0.0f, 0.0f, 5.0f})) << "behind the wall";
  EXPECT_FALSE(IsEmpty(space, {9.0f, 0.0f, 2.0f})) << "in no frame";
  EXPECT_FALSE(IsEmpty(space, {0.0f, 0.0f, -2.0f})) << "behind the cameras";
  const SeenSpace by_one(scene, std::span(maps).first(1));
  EXPECT_FALSE(IsEmpty(by_one, {0.0f, 0.0f, 2.0f}));
}

TEST(SeenSpace, ExcludesWhatOneMapShows) {
  const Scene scene = ViewsOfAWall(3);
  std::vector<StereoDepth> maps = {MapOf(scene, 0, 4.0f), MapOf(scene, 1, 4.0f),
                                   MapOf(scene, 2, 2.0f)};
  EXPECT_FALSE(IsEmpty(SeenSpace(scene, maps), {0.0f, 0.0f, 2.0f}));
  EXPECT_TRUE(IsEmpty(SeenSpace(scene, maps), {0.0f, 0.0f, 1.5f}));
  // Depths that only one view confirms do not count.
  maps[2] = MapOf(scene, 2, 2.0f, 1);
  EXPECT_TRUE(IsEmpty(SeenSpace(scene, maps), {0.0f, 0.0f, 2.0f}));
}

TEST(SeenSpace, TakesTheLeastDepthOfABlock) {
  const Scene scene = ViewsOfAWall(2);
  std::vector<StereoDepth> maps = {MapOf(scene, 0, 4.0f), MapOf(scene, 1, 4.0f)};
  // A pole of one pixel, beside the pixel of the point but in its block.
  for (StereoDepth& map : maps) map.depth[map.Index(33, 25)] = 2.5f;
  EXPECT_FALSE(IsEmpty(SeenSpace(scene, maps), {0.0f, 0.0f, 2.5f}));
}

TEST(SeenSpace, IsLeftToThePhotosWhereManyLook) {
  for (const int cameras : {12, 13}) {
    const Scene scene = ViewsOfAWall(cameras);
    const std::vector<StereoDepth> maps = {MapOf(scene, 0, 4.0f), MapOf(scene, 1, 4.0f)};
    EXPECT_EQ(IsEmpty(SeenSpace(scene, maps), {0.0f, 0.0f, 2.0f}), cameras == 12);
  }
}

TEST(SeenSpace, IsReadFromTheMapsOfTheStart) {
  const ScratchFolder folder;
  const Scene scene = ViewsOfAWall(2);
  EXPECT_TRUE(SeenSpace::Read(scene, folder.path()).empty());
  std::filesystem::create_directories(folder.path() / "depth");
  for (const uint32_t view : {0u, 1u}) {
    WriteStereoDepth(folder.path() / "depth" / StereoDepthName(view), MapOf(scene, view, 4.0f));
  }
  EXPECT_TRUE(IsEmpty(SeenSpace::Read(scene, folder.path()), {0.0f, 0.0f, 2.0f}));
  WriteStereoDepth(folder.path() / "depth" / StereoDepthName(1), MapOf(scene, 0, 4.0f));
  ExpectError<DataError>([&] { SeenSpace::Read(scene, folder.path()); },
                         {"0001.depth", "view 0, not 1"});
}

}  // namespace
}  // namespace tetrec
