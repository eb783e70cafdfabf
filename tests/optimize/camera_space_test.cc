#include "optimize/camera_space.h"

#include "optimize/ring_scene.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

bool IsInside(const Scene& scene, const glm::dvec3& point) {
  const std::vector<glm::vec3> points = {glm::vec3(point)};
  return InsideCapsules(points, FindCameraSpace(scene))[0] != 0;
}

TEST(CameraSpace, ContainsTheCamerasAndWhatIsBetweenNeighbours) {
  const Scene scene = RingOfCameras(12, 500);
  for (int i = 0; i < 24; ++i) EXPECT_TRUE(IsInside(scene, OnRing(i / 24.0))) << i;
  // The nearest points are 2 away from the cameras; half of that is empty, and a little more
  // between the cameras beside this one.
  EXPECT_TRUE(IsInside(scene, 2.1 / kRing * OnRing(0.0)));
  EXPECT_FALSE(IsInside(scene, 1.6 / kRing * OnRing(0.0)));
}

TEST(CameraSpace, ContainsNoPointOfTheSceneWhereverTheCamerasAre) {
  for (const int cameras : {1, 2, 3, 5, 40}) {
    const Scene scene = RingOfCameras(cameras, 500);
    std::vector<glm::vec3> points;
    for (const ScenePoint& point : scene.points) points.emplace_back(point.position);
    for (const uint8_t inside : InsideCapsules(points, FindCameraSpace(scene))) {
      EXPECT_EQ(inside, 0) << cameras << " cameras";
    }
  }
}

TEST(CameraSpace, IsNotSpoiltByAStrayPointInFrontOfACamera) {
  Scene scene = RingOfCameras(12, 1000);
  const glm::dvec3 near = 2.5 / kRing * OnRing(0.0);
  ASSERT_TRUE(IsInside(scene, near));
  ScenePoint stray;
  stray.position = OnRing(0.0) + glm::dvec3(0.01, 0.0, 0.0);
  scene.points.push_back(stray);
  EXPECT_TRUE(IsInside(scene, near));
}

TEST(CameraSpace, OfTestViewsIsNotKnown) {
  Scene scene = RingOfCameras(2, 500);
  const glm::dvec3 far_away(0.0, 0.0, 50.0);
  View test;
  test.split = Split::kTest;
  test.cam_from_world.translation = -far_away;
  scene.views.push_back(test);
  EXPECT_FALSE(IsInside(scene, far_away));
}

TEST(CameraSpace, IsEmptyWhereFewPointsSayHowFarTheSceneIs) {
  EXPECT_TRUE(FindCameraSpace(RingOfCameras(12, 49)).empty());
  EXPECT_TRUE(FindCameraSpace(RingOfCameras(12, 0)).empty());
  EXPECT_FALSE(FindCameraSpace(RingOfCameras(12, 50)).empty());
}

}  // namespace
}  // namespace tetrec
