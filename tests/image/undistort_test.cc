// Images resampled to a pinhole camera.
#include "image/undistort.h"

#include "core/error.h"
#include "expect_error.h"
#include "geometry/undistorted_camera.h"
#include "lenses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

TEST(Undistort, AlphaIsPremultipliedWhileFiltering) {
  // Opaque green on the left, invisible red on the right, which must not bleed in.
  Image photo = MakeImage(640, 480, 4);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) {
      const bool left = x < 321;
      const uint8_t rgba[4] = {uint8_t(left ? 0 : 255), uint8_t(left ? 200 : 0), 0,
                               uint8_t(left ? 255 : 0)};
      std::copy_n(rgba, 4, photo.At(x, y));
    }
  }
  const Camera to = UndistortedCamera(OpenCvLens(), 200);
  const Image picture = Undistort(photo, OpenCvLens(), to);
  int mixed = 0;
  for (int y = 0; y < to.height; ++y) {
    for (int x = 0; x < to.width; ++x) {
      const uint8_t* pixel = picture.At(x, y);
      EXPECT_EQ(pixel[0], 0);
      EXPECT_EQ(pixel[1], pixel[3] > 0 ? 200 : 0);
      mixed += pixel[3] > 0 && pixel[3] < 255;
    }
  }
  EXPECT_GT(mixed, to.height / 2);  // the border between them
}

// A linear ramp of brightness passes bilinear samples and area means unchanged: the value at a
// target pixel's centre is the ramp at the place that the lens gives, apart from the curvature of
// the lens inside a pixel and rounding to 8 bits.
TEST(Undistort, PixelsLandWhereTheLensPutsThem) {
  const Lens from = OpenCvLens();
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

TEST(Undistort, ComplaintsNamePhotoLensAndAdvice) {
  const Lens lens{LensModel::kSimpleRadial, 640, 480, {300, 320, 240, -3.0}};
  ExpectError<DataError>(
      [&] {
        NamingLens(
            "photos/a.jpg", lens, [&] { UndistortedCamera(lens, 640); }, "try another");
      },
      {"photos/a.jpg (lens SIMPLE_RADIAL): the lens distortion", "folds over; try another"});
}

}  // namespace
}  // namespace tetrec
