#include "optimize/photo_frames.h"

#include "optimize/ring_scene.h"

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <cstdint>
#include <vector>

namespace tetrec {
namespace {

constexpr glm::dvec3 kCenter(0.0, 0.0, 1.0);

// Cameras side by side, 0.1 apart along x, that look along z. A frame is as wide as it is far away.
Scene Row(int cameras) {
  Scene scene = RingOfCameras(cameras, 0);
  double x = 0;
  for (View& view : scene.views) {
    view.cam_from_world = {glm::dmat3(1.0), {-x, 0.0, kRing}};
    x += 0.1;
  }
  return scene;
}

TEST(PhotoFrames, CountTheTrainingPhotosThatHaveAPlaceInTheirFrame) {
  Scene scene = Row(13);
  EXPECT_TRUE(PhotoFrames(scene).ManyShow(kCenter));
  EXPECT_TRUE(PhotoFrames(scene).ManyShow({-0.75, 0.0, 1.0}));
  EXPECT_FALSE(PhotoFrames(scene).ManyShow({-0.85, 0.0, 1.0}));  // beside the last frame
  EXPECT_FALSE(PhotoFrames(scene).ManyShow({0.0, 0.0, -9.0}));   // behind the cameras
  scene.views[4].split = Split::kTest;
  EXPECT_FALSE(PhotoFrames(scene).ManyShow(kCenter));
  EXPECT_FALSE(PhotoFrames().ManyShow(kCenter));
}

TEST(PhotoFrames, AnswerForManyPlaces) {
  const std::vector<glm::vec3> places = {glm::vec3(kCenter), {9.0f, 0.0f, 1.0f}};
  EXPECT_EQ(PhotoFrames(Row(13)).ManyShow(places), (std::vector<uint8_t>{1, 0}));
}

}  // namespace
}  // namespace tetrec
