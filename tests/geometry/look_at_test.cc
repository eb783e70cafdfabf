// Cameras that look at a point.
#include "geometry/look_at.h"

#include "geometry/rotation.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(CamLookingAt, PutsTheTargetOnTheAxisAndUpUpwards) {
  const glm::dvec3 eye(1, -2, 0.5), target(0.3, 0.4, -1), up(0.1, 0.9, 0.3);
  const Rigid3 cam_from_world = CamLookingAt(eye, target, up);
  EXPECT_LT(DistanceFromRotation(cam_from_world.rotation), 1e-14);
  EXPECT_LT(glm::length(cam_from_world * eye), 1e-14);
  const glm::dvec3 in_cam = cam_from_world * target;
  EXPECT_LT(glm::length(in_cam - glm::dvec3(0, 0, glm::distance(eye, target))), 1e-14);
  const glm::dvec3 up_in_cam = cam_from_world.rotation * up;
  EXPECT_NEAR(up_in_cam.x, 0, 1e-15);
  EXPECT_LT(up_in_cam.y, 0);  // y points down
}

TEST(CamLookingAt, IsARotationAlongUpToo) {
  for (const glm::dvec3& up : {glm::dvec3(0, 0, 1), glm::dvec3(0, -1, 0), glm::dvec3(1, 0, 0)}) {
    for (const double side : {-1.0, 1.0}) {
      const glm::dmat3 rotation = CamFromWorldRotation(side * up, up);
      EXPECT_LT(DistanceFromRotation(rotation), 1e-14);
      EXPECT_LT(glm::length(rotation * up - glm::dvec3(0, 0, side)), 1e-15);
    }
  }
  // Along z the image's x is the world's.
  EXPECT_EQ(CamFromWorldRotation({0, 0, -1}, {0, 0, 1}) * glm::dvec3(1, 0, 0), glm::dvec3(1, 0, 0));
}

}  // namespace
}  // namespace tetrec
