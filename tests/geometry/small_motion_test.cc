#include "geometry/small_motion.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

constexpr Camera kCamera{320, 240, 300, 300, 160, 120};

TEST(SmallMotion, OfARotationVectorTurnsByItsLengthAboutItsAxis) {
  const glm::dvec3 vector(0.1, -0.4, 0.2);
  const Rigid3 motion = MotionOf(vector, {1, 2, 3});
  EXPECT_LT(glm::length(motion.rotation * vector - vector), 1e-15);
  // The trace of a rotation is 1 + 2 cos of its angle.
  const double trace = motion.rotation[0][0] + motion.rotation[1][1] + motion.rotation[2][2];
  EXPECT_NEAR(std::acos((trace - 1) / 2), glm::length(vector), 1e-12);
  EXPECT_LT(glm::length(RotationVector(motion.rotation) - vector), 1e-14);
  EXPECT_EQ(RotationVector(glm::dmat3(1.0)), glm::dvec3(0.0));
}

TEST(SmallMotion, IsReadBackInPixels) {
  const MotionUnits units = MotionUnitsOf(kCamera, 4.0);
  const MotionPx px = {1, -2, 0.5, 3, 0.1, -0.7};
  const MotionPx back = MotionPxOf(MotionOf(px, units), units);
  for (size_t i = 0; i < 6; ++i) EXPECT_NEAR(back[i], px[i], 1e-12) << i;
}

// A unit moves the middle of the picture (x and y) or what is half of the shorter side away from it
// (z) by a pixel, so the mean over the picture is of that order.
TEST(SmallMotion, OfOneUnitShiftsThePictureByAboutAPixel) {
  for (const double depth : {0.5, 40.0}) {
    const MotionUnits units = MotionUnitsOf(kCamera, depth);
    for (size_t i = 0; i < 6; ++i) {
      MotionPx px{};
      px[i] = 1;
      const double shift = PictureShift(kCamera, MotionOf(px, units), depth);
      EXPECT_GT(shift, 0.7) << i;
      EXPECT_LT(shift, 1.3) << i;
    }
  }
  EXPECT_EQ(PictureShift(kCamera, {}, 1.0), 0.0);
}

TEST(SmallMotion, BehindWhatIsSeenShiftsThePictureWithoutBound) {
  EXPECT_TRUE(std::isinf(PictureShift(kCamera, MotionOf(glm::dvec3(0.0), {0, 0, -2}), 1.0)));
}

}  // namespace
}  // namespace tetrec
