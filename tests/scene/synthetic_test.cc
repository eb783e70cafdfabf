#include "scene/synthetic.h"

#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

constexpr double kPi = 3.14159265358979323846;

SyntheticOptions Small(SyntheticKind kind) {
  SyntheticOptions options;
  options.kind = kind;
  options.train_views = 6;
  options.validation_views = 2;
  options.test_views = 3;
  options.width = 48;
  options.height = 40;
  return options;
}

TEST(SyntheticScene, FogEqualsTheVolumeIntegralByQuadrature) {
  const SyntheticOptions options = Small(SyntheticKind::kFog);
  for (const glm::dvec3& target :
       {glm::dvec3(0.0), glm::dvec3(0.3, 0.5, 0), glm::dvec3(0, 0.7, -0.5)}) {
    const glm::dvec3 origin(3, 0.2, 0.1), direction = glm::normalize(target - origin);
    // Midpoint rule over [1, 5] with colour 0.5 + 0.5 x, as the header specifies.
    const int steps = 400000;
    const double step = 4.0 / steps;
    double tau = 0;
    glm::dvec3 color(0.0);
    for (int i = 0; i < steps; ++i) {
      const glm::dvec3 point = origin + (1 + (i + 0.5) * step) * direction;
      if (!IsInSubject(options.kind, point)) continue;
      const double thickness = kFogDensity * step;
      color += std::exp(-(tau + 0.5 * thickness)) * thickness * (0.5 + 0.5 * point);
      tau += thickness;
    }
    const RaySample sample = SampleSynthetic(options, origin, direction);
    // The rule errs by at most one step's contribution at each end: 2.5 * 1e-5.
    EXPECT_NEAR(sample.alpha, 1 - std::exp(-tau), 5e-5);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sample.premultiplied_srgb[c], color[c], 5e-5);
  }
  EXPECT_EQ(SampleSynthetic(options, {3, 0, 0}, {0, 1, 0}).alpha, 0);
}

TEST(SyntheticScene, BallCoversTheAreaOfItsOutline) {
  const SyntheticScene synthetic = MakeSyntheticScene(Small(SyntheticKind::kBall));
  const Camera& camera = synthetic.scene.cameras[0];
  // The outline of a ball of radius 0.9 seen from 3 is a circle about the axis.
  const double radius_px = camera.fx * std::tan(std::asin(0.9 / 3.0));
  for (const Image& image : synthetic.images) {
    ASSERT_EQ(image.channels, 4);
    double area = 0;
    for (size_t i = 3; i < image.pixels.size(); i += 4) area += image.pixels[i] / 255.0;
    // With 3 x 3 rays per pixel, each of the about 2 pi r border pixels is accurate to 1 / 9, with
    // mixed signs.
    EXPECT_NEAR(area, kPi * radius_px * radius_px, 0.01 * kPi * radius_px * radius_px);
  }
}

TEST(SyntheticScene, HasItsViewsInSplitsAndLooksAtTheCentre) {
  for (const SyntheticKind kind : {SyntheticKind::kTwoBalls, SyntheticKind::kRoom}) {
    const SyntheticScene synthetic = MakeSyntheticScene(Small(kind));
    const Scene& scene = synthetic.scene;
    const bool is_room = kind == SyntheticKind::kRoom;
    EXPECT_EQ(scene.ViewsOf(Split::kTrain).size(), is_room ? 8u : 6u);
    EXPECT_EQ(scene.ViewsOf(Split::kValidation).size(), is_room ? 0u : 2u);
    EXPECT_EQ(scene.ViewsOf(Split::kTest).size(), 3u);
    EXPECT_EQ(scene.has_alpha, !is_room);
    ASSERT_EQ(synthetic.images.size(), scene.views.size());
    for (const View& view : scene.views) {
      const glm::dvec2 pixel = scene.cameras[0].ImageFromCam(view.cam_from_world * glm::dvec3(0.0));
      EXPECT_LT(glm::length(pixel - glm::dvec2(24, 20)), 1e-9);
      const glm::dvec3 above = view.cam_from_world * glm::dvec3(0, 0, 0.1);
      EXPECT_LT(scene.cameras[0].ImageFromCam(above).y, 20);  // z is up
    }
  }
}

TEST(SyntheticScene, PointsHaveTheColourOfTheImagesThatSeeThem) {
  SyntheticOptions options = Small(SyntheticKind::kRoom);
  options.points = 200;
  const SyntheticScene synthetic = MakeSyntheticScene(options);
  ASSERT_EQ(synthetic.scene.points.size(), 200u);
  for (const ScenePoint& point : synthetic.scene.points) {
    EXPECT_GE(point.track_length, 2u);
    const glm::dvec3 size = glm::abs(point.position);
    const double radius = glm::length(point.position);
    const double wall = std::max({size.x, size.y, size.z});
    EXPECT_TRUE(std::abs(radius - 0.9) < 1e-9 || std::abs(wall - 4) < 1e-9) << radius;
    uint32_t seen = 0;
    for (const int i : synthetic.scene.ViewsOf(Split::kTrain)) {
      const Rigid3& cam_from_world = synthetic.scene.views[size_t(i)].cam_from_world;
      const glm::dvec3 origin = cam_from_world.Inverse().translation;
      const glm::dvec3 direction = point.position - origin;
      // The ball hides the point if the ray to it passes through the ball.
      const double nearest =
          std::clamp(-glm::dot(origin, direction) / glm::dot(direction, direction), 0.0, 1.0);
      if (glm::length(origin + nearest * direction) < 0.9 - 1e-9) continue;
      const RaySample sample = SampleSynthetic(options, origin, direction);
      for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(255 * sample.premultiplied_srgb[c], point.color_srgb[size_t(c)], 0.5 + 1e-6);
      }
      const glm::dvec3 in_cam = cam_from_world * point.position;
      const glm::dvec2 pixel = synthetic.scene.cameras[0].ImageFromCam(in_cam);
      const bool in_picture = pixel.x >= 0 && pixel.y >= 0 && pixel.x < 48 && pixel.y < 40;
      seen += in_cam.z > 0 && in_picture ? 1 : 0;
    }
    EXPECT_EQ(seen, point.track_length);
  }
}

TEST(SyntheticScene, IsTheSameForTheSameSeedOnly) {
  SyntheticOptions options = Small(SyntheticKind::kBall);
  const SyntheticScene a = MakeSyntheticScene(options), b = MakeSyntheticScene(options);
  options.seed = 2;
  const SyntheticScene c = MakeSyntheticScene(options);
  EXPECT_EQ(a.images[0].pixels, b.images[0].pixels);
  EXPECT_NE(a.images[0].pixels, c.images[0].pixels);
}

TEST(SyntheticScene, IsReadBackFromItsFolder) {
  const ScratchFolder folder;
  SyntheticOptions options = Small(SyntheticKind::kBall);
  options.points = 20;
  const SyntheticScene synthetic = MakeSyntheticScene(options);
  WriteSyntheticScene(folder.path(), synthetic);
  const Scene scene = ReadScene(folder.path());
  ASSERT_EQ(scene.views.size(), synthetic.scene.views.size());
  EXPECT_EQ(scene.points.size(), 20u);
  for (size_t i = 0; i < scene.views.size(); ++i) {
    EXPECT_EQ(ReadImage(folder / scene.views[i].image).pixels, synthetic.images[i].pixels);
  }
}

}  // namespace
}  // namespace tetrec
