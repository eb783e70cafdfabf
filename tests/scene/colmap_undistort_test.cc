// Undistortion: the lens and its inverse, the pinhole camera, and the resampled picture.
#include "scene/colmap_undistort.h"

#include "core/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

// A strong barrel lens with all terms; 1 % of the width at the corners and more.
ColmapCamera OpenCvCamera() {
  return {4, 640, 480, {500, 510, 330, 235, -0.12, 0.05, 0.002, -0.003}};
}
ColmapCamera PinholeCamera() { return {1, 640, 480, {500, 510, 330, 235}}; }

TEST(Undistort, TheInverseOfTheLensIsItsInverse) {
  for (const ColmapCamera& camera :
       {OpenCvCamera(), PinholeCamera(), ColmapCamera{2, 640, 480, {500, 320, 240, 0.1}},
        ColmapCamera{3, 640, 480, {500, 320, 240, -0.1, 0.02}}}) {
    for (double y = 0; y <= 480; y += 40) {
      for (double x = 0; x <= 640; x += 40) {
        const glm::dvec2 back =
            DistortedImageFromCam(camera, CamFromDistortedImage(camera, {x, y}));
        // Newton's tolerance 1e-10 times the focal length.
        EXPECT_NEAR(glm::distance(back, glm::dvec2(x, y)), 0, 1e-7);
      }
    }
  }
}

// OpenCV's published formula, written out a second time for one direction.
TEST(Undistort, TheLensIsThatOfTheBooks) {
  const double x = 0.3, y = -0.2, r2 = 0.13, k1 = -0.12, k2 = 0.05, p1 = 0.002, p2 = -0.003;
  const double u = x * (1 + k1 * r2 + k2 * r2 * r2) + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
  const double v = y * (1 + k1 * r2 + k2 * r2 * r2) + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
  const glm::dvec2 pixel = DistortedImageFromCam(OpenCvCamera(), {x, y});
  EXPECT_NEAR(pixel.x, 500 * u + 330, 1e-9);
  EXPECT_NEAR(pixel.y, 510 * v + 235, 1e-9);
}

TEST(Undistort, EveryPixelOfThePinholePictureComesFromInsideThePhoto) {
  for (const int max_size : {100, 640, 5000}) {
    const ColmapCamera from = OpenCvCamera();
    const Camera to = UndistortedCamera(from, max_size);
    EXPECT_LE(std::max(to.width, to.height), std::min(max_size, 640));
    EXPECT_NEAR(double(to.width) / to.height, 640.0 / 480.0, 1.0 / to.height);
    for (int y = 0; y <= to.height; y += std::max(1, to.height / 20)) {
      for (int x = 0; x <= to.width; x += std::max(1, to.width / 20)) {
        const glm::dvec3 direction = to.CamFromImage(glm::dvec2(x, y));
        const glm::dvec2 pixel = DistortedImageFromCam(from, {direction.x, direction.y});
        // The window's borders are sampled at 257 points; between them the lens bends by less.
        EXPECT_GE(std::min(pixel.x, pixel.y), -0.05);
        EXPECT_LE(pixel.x, 640.05);
        EXPECT_LE(pixel.y, 480.05);
      }
    }
  }
}

TEST(Undistort, APinholeCameraKeepsItsPictureAndItsParameters) {
  const Camera to = UndistortedCamera(PinholeCamera(), 640);
  EXPECT_EQ(to.width, 640);
  EXPECT_EQ(to.height, 480);
  EXPECT_NEAR(to.fx, 500, 1e-6);
  EXPECT_NEAR(to.cy, 235, 1e-6);
  const Camera half = UndistortedCamera(PinholeCamera(), 320);
  EXPECT_NEAR(half.fx, 250, 1e-6);
  EXPECT_NEAR(half.cx, 165, 1e-6);
}

// A linear ramp of brightness goes through bilinear samples and area means unchanged: its value at
// a target pixel's centre is the ramp at the place that the lens gives, but for the curvature of
// the lens inside a pixel and rounding to 8 bits.
TEST(Undistort, PixelsLandWhereTheLensSays) {
  const ColmapCamera from = OpenCvCamera();
  Image photo{640, 480, 3, std::vector<uint8_t>(640 * 480 * 3)};
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      photo.At(x, y)[0] = uint8_t(std::lround((x + 0.5) * 255 / 640));
      photo.At(x, y)[1] = uint8_t(std::lround((y + 0.5) * 255 / 480));
      photo.At(x, y)[2] = 77;
    }
  }
  for (const int max_size : {200, 640}) {
    const Camera to = UndistortedCamera(from, max_size);
    const Image picture = Undistort(photo, from, to);
    ASSERT_EQ(picture.width, to.width);
    for (int y = 2; y < to.height - 2; y += 7) {
      for (int x = 2; x < to.width - 2; x += 7) {
        const glm::dvec3 direction = to.CamFromImage(glm::dvec2(x, y) + 0.5);
        const glm::dvec2 pixel = DistortedImageFromCam(from, {direction.x, direction.y});
        EXPECT_NEAR(picture.At(x, y)[0], pixel.x * 255 / 640, 1.1);  // two roundings of 0.5 each
        EXPECT_NEAR(picture.At(x, y)[1], pixel.y * 255 / 480, 1.1);
        EXPECT_EQ(picture.At(x, y)[2], 77);
      }
    }
  }
}

TEST(Undistort, LensesThatFoldOverOrAreUnknownAreRefused) {
  EXPECT_THROW(UndistortedCamera({2, 640, 480, {300, 320, 240, -3.0}}, 640), DataError);
  EXPECT_THROW(UndistortedCamera({1, 640, 480, {-500, 510, 330, 235}}, 640), DataError);
  EXPECT_FALSE(CanUndistort({5, 640, 480, {500, 500, 320, 240, 0, 0, 0, 0}}));
  EXPECT_THROW(UndistortedCamera({5, 640, 480, {500, 500, 320, 240, 0, 0, 0, 0}}, 640), DataError);
}

}  // namespace
}  // namespace tetrec
