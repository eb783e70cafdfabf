#include "optimize/photo_sight.h"

#include "core/error.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

namespace tetrec {
namespace {

// Cameras in a row that look along z at a wall at z = 4. A frame is as wide as it is far away.
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

std::vector<StereoDepth> MapsOf(const Scene& scene, uint32_t count, float wall) {
  std::vector<StereoDepth> maps;
  for (uint32_t view = 0; view < count; ++view) maps.push_back(MapOf(scene, view, wall));
  return maps;
}

PlaceSight SightOf(const PhotoSight& sight, const glm::vec3& place) {
  return sight.Of(std::vector<glm::vec3>{place})[0];
}

bool IsEmpty(const PhotoSight& sight, const glm::vec3& place) {
  return SightOf(sight, place).is_empty;
}

bool IsOfMany(const PhotoSight& sight, const glm::vec3& place) {
  return SightOf(sight, place).is_of_many;
}

bool IsSurface(const PhotoSight& sight, const glm::vec3& place) {
  return SightOf(sight, place).is_surface;
}

TEST(PhotoSight, OfFewPhotosIsEmptyInFrontOfWhatTwoMapsShow) {
  const Scene scene = ViewsOfAWall(3);
  const std::vector<StereoDepth> maps = MapsOf(scene, 2, 4.0f);
  const PhotoSight sight(scene, maps);
  EXPECT_TRUE(IsEmpty(sight, {0.0f, 0.0f, 2.0f}));
  EXPECT_TRUE(IsEmpty(sight, {0.0f, 0.0f, 3.7f}));
  EXPECT_FALSE(IsEmpty(sight, {0.0f, 0.0f, 3.9f})) << "at the wall";
  EXPECT_FALSE(IsEmpty(sight, {0.0f, 0.0f, 5.0f})) << "behind the wall";
  EXPECT_FALSE(IsEmpty(sight, {9.0f, 0.0f, 2.0f})) << "in no frame";
  EXPECT_FALSE(IsEmpty(sight, {0.0f, 0.0f, -2.0f})) << "behind the cameras";
  EXPECT_FALSE(IsEmpty(PhotoSight(scene, std::span(maps).first(1)), {0.0f, 0.0f, 2.0f}));
  EXPECT_FALSE(IsEmpty(PhotoSight(scene), {0.0f, 0.0f, 2.0f}));
}

TEST(PhotoSight, IsNotEmptyWhereOneMapShowsSomething) {
  const Scene scene = ViewsOfAWall(3);
  std::vector<StereoDepth> maps = MapsOf(scene, 2, 4.0f);
  maps.push_back(MapOf(scene, 2, 2.0f));
  EXPECT_FALSE(IsEmpty(PhotoSight(scene, maps), {0.0f, 0.0f, 2.0f}));
  EXPECT_TRUE(IsEmpty(PhotoSight(scene, maps), {0.0f, 0.0f, 1.5f}));
  // Depths that only one view confirms do not count.
  maps[2] = MapOf(scene, 2, 2.0f, 1);
  EXPECT_TRUE(IsEmpty(PhotoSight(scene, maps), {0.0f, 0.0f, 2.0f}));
}

TEST(PhotoSight, TakesTheLeastDepthOfABlock) {
  const Scene scene = ViewsOfAWall(2);
  std::vector<StereoDepth> maps = MapsOf(scene, 2, 4.0f);
  // A pole of one pixel, beside the pixel of the place but in its block.
  for (StereoDepth& map : maps) map.depth[map.Index(33, 25)] = 2.5f;
  EXPECT_FALSE(IsEmpty(PhotoSight(scene, maps), {0.0f, 0.0f, 2.5f}));
}

TEST(PhotoSight, IsOfManyWhereMoreThan12TrainingPhotosSeeAPlace) {
  for (const int cameras : {12, 13}) {
    const Scene scene = ViewsOfAWall(cameras);
    EXPECT_EQ(IsOfMany(PhotoSight(scene), {0.0f, 0.0f, 2.0f}), cameras == 13);
    EXPECT_EQ(IsEmpty(PhotoSight(scene, MapsOf(scene, 2, 4.0f)), {0.0f, 0.0f, 2.0f}),
              cameras == 12);
  }
  Scene scene = ViewsOfAWall(13);
  const std::vector<glm::vec3> places = {
      {0.06f, 0.0f, 2.0f}, {0.0f, 0.0f, -9.0f}, {-0.95f, 0.0f, 2.0f}};
  const std::vector<PlaceSight> expected = {{.is_of_many = true}, {}, {}};
  EXPECT_EQ(PhotoSight(scene).Of(places), expected) << "behind the cameras, beside some frames";
  scene.views[4].split = Split::kTest;
  EXPECT_FALSE(IsOfMany(PhotoSight(scene), {0.06f, 0.0f, 2.0f}));
  EXPECT_FALSE(IsOfMany(PhotoSight(), {0.06f, 0.0f, 2.0f}));
}

TEST(PhotoSight, IsNotOfPhotosWhoseMapsShowSomethingInFront) {
  const Scene scene = ViewsOfAWall(13);
  const PhotoSight all_but_one(scene, MapsOf(scene, 12, 4.0f));
  const PhotoSight one_hidden(scene, MapsOf(scene, 1, 4.0f));
  const glm::vec3 at_wall(0.0f, 0.0f, 4.05f), behind(0.0f, 0.0f, 4.1f);
  EXPECT_TRUE(IsOfMany(all_but_one, at_wall));
  EXPECT_FALSE(IsOfMany(one_hidden, behind));
  EXPECT_EQ(SightOf(all_but_one, behind), PlaceSight()) << "hidden is not empty";
  EXPECT_TRUE(IsOfMany(PhotoSight(scene), behind));
}

// A place that one map may show is not known to be empty, even where that map hides it by a little.
TEST(PhotoSight, IsNotEmptyCloseBehindWhatAMapShows) {
  const Scene scene = ViewsOfAWall(3);
  std::vector<StereoDepth> maps = MapsOf(scene, 2, 8.0f);
  maps.push_back(MapOf(scene, 2, 4.0f));
  EXPECT_FALSE(IsEmpty(PhotoSight(scene, maps), {0.0f, 0.0f, 4.15f}));
  EXPECT_TRUE(IsEmpty(PhotoSight(scene, maps), {0.0f, 0.0f, 4.3f}));
}

// A floor at a flat angle does not hide itself, and a pole hides nothing beside it.
TEST(PhotoSight, IsHiddenOnlyBehindTheLargestDepthOfABlock) {
  const Scene scene = ViewsOfAWall(13);
  std::vector<StereoDepth> maps = MapsOf(scene, 13, 4.0f);
  for (StereoDepth& map : maps) map.depth[map.Index(33, 25)] = 2.5f;
  EXPECT_TRUE(IsOfMany(PhotoSight(scene, maps), {0.0f, 0.0f, 4.0f}));
  EXPECT_FALSE(IsOfMany(PhotoSight(scene, maps), {0.0f, 0.0f, 4.2f}));
}

TEST(PhotoSight, IsASurfaceRightWhereEnoughMapsShowOne) {
  const Scene scene = ViewsOfAWall(21);
  const PhotoSight sight(scene, MapsOf(scene, 3, 4.0f));
  EXPECT_TRUE(IsSurface(sight, {0.0f, 0.0f, 4.0f}));
  EXPECT_TRUE(IsSurface(sight, {0.0f, 0.0f, 4.05f})) << "just behind";
  EXPECT_TRUE(IsSurface(sight, {0.0f, 0.0f, 3.99f})) << "within the error of depths";
  EXPECT_FALSE(IsSurface(sight, {0.0f, 0.0f, 4.08f}));
  EXPECT_FALSE(IsSurface(sight, {0.0f, 0.0f, 3.96f}));
  EXPECT_FALSE(IsSurface(PhotoSight(scene, MapsOf(scene, 2, 4.0f)), {0.0f, 0.0f, 4.0f}));
  EXPECT_FALSE(IsSurface(PhotoSight(scene), {0.0f, 0.0f, 4.0f}));
  const Scene few = ViewsOfAWall(20);
  EXPECT_TRUE(IsSurface(PhotoSight(few, MapsOf(few, 2, 4.0f)), {0.0f, 0.0f, 4.0f}));
  EXPECT_FALSE(IsSurface(PhotoSight(few, MapsOf(few, 1, 4.0f)), {0.0f, 0.0f, 4.0f}));
}

TEST(PhotoSight, IsNoSurfaceThroughWhichManyMapsShowAnother) {
  const Scene scene = ViewsOfAWall(21);
  for (const auto& [at, through, is_surface] :
       {std::tuple(10u, 2u, true), std::tuple(10u, 3u, false), std::tuple(4u, 1u, false)}) {
    std::vector<StereoDepth> maps = MapsOf(scene, at, 4.0f);
    for (uint32_t view = at; view < at + through; ++view) maps.push_back(MapOf(scene, view, 6.0f));
    EXPECT_EQ(IsSurface(PhotoSight(scene, maps), {0.0f, 0.0f, 4.0f}), is_surface) << at;
    // Maps that hide the place do not count.
    for (uint32_t view = at; view < at + through; ++view) maps[view] = MapOf(scene, view, 2.0f);
    EXPECT_TRUE(IsSurface(PhotoSight(scene, maps), {0.0f, 0.0f, 4.0f})) << at;
  }
}

TEST(PhotoSight, IsReadFromTheMapsOfTheStart) {
  const ScratchFolder folder;
  const Scene scene = ViewsOfAWall(2);
  const glm::vec3 place(0.0f, 0.0f, 2.0f);
  EXPECT_FALSE(IsEmpty(PhotoSight::Read(scene, folder.path()), place));
  std::filesystem::create_directories(folder.path() / "depth");
  for (const uint32_t view : {0u, 1u}) {
    WriteStereoDepth(folder.path() / "depth" / StereoDepthName(view), MapOf(scene, view, 4.0f));
  }
  EXPECT_TRUE(IsEmpty(PhotoSight::Read(scene, folder.path()), place));
  WriteStereoDepth(folder.path() / "depth" / StereoDepthName(1), MapOf(scene, 0, 4.0f));
  ExpectError<DataError>([&] { PhotoSight::Read(scene, folder.path()); },
                         {"0001.depth", "view 0, not 1"});
}

}  // namespace
}  // namespace tetrec
