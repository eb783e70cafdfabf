// Cameras turned by multiples of 90 degrees.
#include "geometry/quarter_turns.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

// Where a pixel of an image comes to lie when the image is turned clockwise by 90 degrees.
glm::dvec2 TurnedPixel(const glm::dvec2& pixel, int height) { return {height - pixel.y, pixel.x}; }

TEST(QuarterTurns, ATurnedCameraShowsTheTurnedImage) {
  const Camera camera{640, 480, 500, 510, 300, 250};
  const glm::dvec3 in_cam(0.3, -0.2, 2);
  glm::dvec2 pixel = camera.ImageFromCam(in_cam);
  int height = camera.height, other = camera.width;
  for (int quarters = 1; quarters <= 7; ++quarters) {
    pixel = TurnedPixel(pixel, height);
    std::swap(height, other);
    const Camera turned = TurnedClockwise(camera, quarters);
    EXPECT_EQ(turned.height, height);
    EXPECT_EQ(turned.width, other);
    const glm::dvec2 seen = turned.ImageFromCam(ClockwiseTurn(quarters) * in_cam);
    EXPECT_NEAR(glm::distance(seen, pixel), 0, 1e-9) << quarters;
  }
}

}  // namespace
}  // namespace tetrec
