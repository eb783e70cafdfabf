// Rotation matrices and the nearest rotation.
#include "geometry/rotation.h"

#include "geometry/camera.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

glm::dmat3 Turn(double angle) {
  return glm::dmat3(
      glm::rotate(glm::dmat4(1.0), angle, glm::normalize(glm::dvec3(0.2, 0.9, -0.4))));
}

double LargestDifference(const glm::dmat3& a, const glm::dmat3& b) {
  double largest = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) largest = std::max(largest, std::abs(a[i][j] - b[i][j]));
  }
  return largest;
}

TEST(DistanceFromRotation, IsRoundingForRotationsAndInfiniteForMirrors) {
  EXPECT_LT(DistanceFromRotation(Turn(1.3)), 1e-14);
  EXPECT_NEAR(DistanceFromRotation(2.0 * Turn(1.3)), 3.0, 1e-12);  // |4 - 1|
  EXPECT_EQ(DistanceFromRotation(-Turn(1.3)), INFINITY);
  EXPECT_EQ(DistanceFromRotation(glm::dmat3(std::nan(""))), INFINITY);
}

TEST(NearestRotation, OfARotationTimesASymmetricStretchIsThatRotation) {
  // Polar decomposition: for any symmetric positive S the nearest rotation to R S is R.
  const glm::dmat3 stretch(1.02, 0.01, -0.02, 0.01, 0.97, 0.005, -0.02, 0.005, 1.01);
  const glm::dmat3 nearest = NearestRotation(Turn(2.1) * stretch);
  EXPECT_LT(LargestDifference(nearest, Turn(2.1)), 1e-14);
  EXPECT_LT(DistanceFromRotation(nearest), 1e-14);
}

TEST(Transforms, InverseUndoesAndProductsChain) {
  const Rigid3 b_from_a{Turn(0.7), {1, 2, 3}};
  const Similarity3 d_from_c{3.5, Turn(-1.2), {-4, 0.5, 2}}, c_from_b{0.2, Turn(2.2), {7, -1, 0}};
  const glm::dvec3 point(0.3, -5, 2);
  // A few roundings of values of about 10.
  EXPECT_LT(glm::length(b_from_a.Inverse() * (b_from_a * point) - point), 1e-13);
  EXPECT_LT(glm::length(d_from_c.Inverse() * (d_from_c * point) - point), 1e-13);
  EXPECT_LT(glm::length((d_from_c * c_from_b) * point - d_from_c * (c_from_b * point)), 1e-13);
}

TEST(CamFromWorld, ShowsEveryPointAtTheSamePixel) {
  const Camera camera{640, 480, 500, 510, 322, 239};
  const Rigid3 cam_from_input{Turn(0.4), {0.5, -0.2, 40}};
  const Similarity3 input_from_world{7.5, Turn(-2.0), {1, 2, 3}};
  const Rigid3 cam_from_world = CamFromWorld(cam_from_input, input_from_world);
  EXPECT_LT(DistanceFromRotation(cam_from_world.rotation), 1e-14);
  for (const glm::dvec3& point : {glm::dvec3(0.0), glm::dvec3(1, -1, 0.5), glm::dvec3(0.1, 2, 1)}) {
    const glm::dvec2 direct = camera.ImageFromCam(cam_from_input * (input_from_world * point));
    const glm::dvec2 moved = camera.ImageFromCam(cam_from_world * point);
    EXPECT_LT(glm::length(direct - moved), 1e-10);
  }
}

TEST(Camera, RayThroughAPixelProjectsBackToIt) {
  const Camera camera{640, 480, 500, 510, 322, 239};
  const glm::dvec2 pixel(17.25, 401.5);
  const glm::dvec3 on_ray = 3.7 * camera.CamFromImage(pixel);
  EXPECT_NEAR(on_ray.z, 3.7, 1e-15);
  EXPECT_LT(glm::length(camera.ImageFromCam(on_ray) - pixel), 1e-12);
}

}  // namespace
}  // namespace tetrec
