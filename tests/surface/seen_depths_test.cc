#include "surface/seen_depths.h"

#include "geometry/look_at.h"
#include "mesh/delaunay.h"
#include "render/create_renderer.h"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace tetrec {
namespace {

constexpr float kWallBegins = 0.8f;
const Bounds3 kSubject{glm::dvec3(-1, -1, 0.5), glm::dvec3(1, 1, 1.2)};

// A box that contains an opaque wall at its back, and haze of this optical depth in front of it.
RadianceField HazeBeforeAWall(float optical_depth_of_haze) {
  std::vector<glm::vec3> places;
  for (const float z : {-1.0f, 0.0f, 0.7f, kWallBegins, 1.0f}) {
    for (const float x : {-1.0f, 0.0f, 1.0f}) {
      for (const float y : {-1.0f, 0.0f, 1.0f}) places.emplace_back(x, y, z);
    }
  }
  RadianceField field;
  field.mesh = BuildDelaunay(places).mesh;
  for (const glm::vec3& p : field.mesh.positions) {
    field.density.push_back(p.z >= kWallBegins ? 1000.0f : optical_depth_of_haze / 1.7f);
    field.color_srgb.emplace_back(0.5f);
  }
  return field;
}

double SurfaceDepthOf(float optical_depth_of_haze, const Bounds3& subject = kSubject) {
  const std::unique_ptr<TrainingRenderer> renderer =
      CreateRenderer({.kind = RendererKind::kReference});
  renderer->SetField(HazeBeforeAWall(optical_depth_of_haze));
  const RenderView view{{32, 24, 32, 32, 16, 12},
                        CamLookingAt({0.1, 0.05, -2}, {0, 0, 1}, {0, -1, 0})};
  return FindSurfaceDepth(*renderer, std::vector{view}, subject);
}

TEST(FindSurfaceDepth, IsWhereAThirdOfTheLightIsLostWithoutHaze) {
  EXPECT_DOUBLE_EQ(SurfaceDepthOf(0.0f), 0.4);
  EXPECT_DOUBLE_EQ(SurfaceDepthOf(0.2f), 0.4);
}

TEST(FindSurfaceDepth, PassesHazeThatHidesAThirdOfTheLight) {
  EXPECT_DOUBLE_EQ(SurfaceDepthOf(0.6f), 0.8);
  EXPECT_DOUBLE_EQ(SurfaceDepthOf(1.0f), 1.2);
  EXPECT_DOUBLE_EQ(SurfaceDepthOf(1.6f), 2.0);
}

TEST(FindSurfaceDepth, IgnoresHazeBeforeWhatIsNotTheSubject) {
  EXPECT_DOUBLE_EQ(SurfaceDepthOf(1.6f, {glm::dvec3(-9), glm::dvec3(-8)}), 0.4);
}

}  // namespace
}  // namespace tetrec
