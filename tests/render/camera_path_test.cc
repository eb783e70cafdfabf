#include "render/camera_path.h"

#include "geometry/look_at.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

constexpr double kTolerance = 1e-12;  // a few roundings of numbers near 1

// Cameras at these places that look at the origin.
Scene SceneOf(const std::vector<glm::dvec3>& centers) {
  Scene scene;
  scene.cameras = {{401, 301, 500, 500, 200, 150}};
  scene.subject_bounds = {glm::dvec3(-1), glm::dvec3(1)};
  for (const glm::dvec3& center : centers) {
    scene.views.push_back({"", "", 0, CamLookingAt(center, glm::dvec3(0)), Split::kTrain});
  }
  return scene;
}

glm::dvec3 CenterOf(const Rigid3& cam_from_world) { return cam_from_world.Inverse().translation; }

TEST(CameraPath, AnOrbitGoesOnceAroundTheSubjectAndLooksAtIt) {
  const Scene scene = SceneOf({{4, 0, 1}, {0, 3, 2}, {-5, 0, 3}});
  const auto path = OrbitPath(scene, {0, 1, 2}, 4);
  const glm::dvec3 centers[] = {{4, 0, 2}, {0, 4, 2}, {-4, 0, 2}, {0, -4, 2}};
  ASSERT_EQ(path.size(), 4u);
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_LT(glm::distance(CenterOf(path[i]), centers[i]), kTolerance) << i;
    // The subject is on the optical axis, and up in the world is up in the picture (-y).
    const glm::dvec3 subject = path[i] * glm::dvec3(0);
    EXPECT_NEAR(subject.x, 0, kTolerance);
    EXPECT_NEAR(subject.y, 0, kTolerance);
    EXPECT_GT(subject.z, 0);
    EXPECT_LT((path[i].rotation * glm::dvec3(0, 0, 1)).y, 0);
  }
}

TEST(CameraPath, APathPassesItsCamerasAndMovesEvenlyOnALine) {
  const Scene scene = SceneOf({{4, -2, 1}, {4, 0, 1}, {4, 2, 1}, {4, 6, 1}});
  const auto path = PathThroughCameras(scene, {0, 1, 2, 3}, 9);
  ASSERT_EQ(path.size(), 9u);
  for (size_t i = 0; i < 9; ++i) {
    EXPECT_LT(glm::distance(CenterOf(path[i]), glm::dvec3(4, -2.0 + double(i), 1)), kTolerance)
        << i;
  }
  const size_t frames[] = {0, 2, 4, 8};
  for (size_t key = 0; key < 4; ++key) {
    const glm::dmat3 turn =
        path[frames[key]].rotation * glm::transpose(scene.views[key].cam_from_world.rotation);
    EXPECT_NEAR(turn[0][0] + turn[1][1] + turn[2][2], 3, kTolerance) << key;
  }
}

TEST(CameraPath, CamerasAtOnePlaceOnlyTurn) {
  const Scene scene = SceneOf({{4, 0, 1}, {4, 0, 1}});
  for (const Rigid3& pose : PathThroughCameras(scene, {0, 1}, 3)) {
    EXPECT_LT(glm::distance(CenterOf(pose), glm::dvec3(4, 0, 1)), kTolerance);
  }
}

TEST(CameraPath, VideosHaveEvenSidesAndTheSameFieldOfView) {
  const Camera camera{402, 301, 500, 510, 200, 150};
  for (const int size : {0, 100, 640}) {
    const Camera video = VideoCamera(camera, size);
    EXPECT_EQ(video.width % 2, 0);
    EXPECT_EQ(video.height % 2, 0);
    EXPECT_EQ(video.width, size > 0 ? size : 402);
    EXPECT_NEAR(video.width / video.fx, camera.width / camera.fx, kTolerance);
    EXPECT_NEAR(video.height / video.fy, camera.height / camera.fy, kTolerance);
  }
}

}  // namespace
}  // namespace tetrec
