#include "surface/level.h"

#include "core/error.h"
#include "surface/shapes.h"

#include <gtest/gtest.h>

#include <numbers>

namespace tetrec {
namespace {

// The field is linear along x in the whole box: sigma = slope * (x + 1.5).
RadianceField Ramp(double slope, double scale) {
  RadianceField field;
  field.mesh = JitteredBox(8);
  field.density = Sampled(field.mesh, [&](const glm::dvec3& p) { return slope * (p.x + 1.5); });
  field.color_srgb.resize(field.density.size());
  for (glm::vec3& p : field.mesh.positions) p *= float(scale);
  for (float& d : field.density) d /= float(scale);
  return field;
}

// Along x, slope s^2 / 2 = ln 2, so sigma = slope s = sqrt(2 ln 2 slope). The eye is so far away
// that its rays are parallel to x within 1e-4.
TEST(HalfTransmittanceLevel, IsTheClosedFormOnALinearRampAtAnyScale) {
  for (const double scale : {0.01, 1.0, 100.0}) {
    const RadianceField field = Ramp(3, scale);
    const Bounds3 bounds{glm::dvec3(-1.4 * scale), glm::dvec3(1.4 * scale)};
    const std::vector<glm::dvec3> eyes = {{-2e4 * scale, 0, 0}};
    const HalfTransmittanceLevel level = FindHalfTransmittanceLevel(field, bounds, eyes, 500, 1);
    EXPECT_EQ(level.lost_rays, 0u);
    EXPECT_EQ(level.opaque_rays, 500u);
    const double expected = std::sqrt(2 * std::numbers::ln2 * 3) / scale;
    EXPECT_NEAR(level.isovalue, expected, 1e-3 * expected);  // obliquity 1e-4, float vertices
  }
}

TEST(HalfTransmittanceLevel, CutsASteepBallNearItsWall) {
  RadianceField field;
  field.mesh = JitteredBox(20);
  field.density =
      Sampled(field.mesh, [](const glm::dvec3& p) { return 200 * std::max(0.0, Ball(p)); });
  field.color_srgb.resize(field.density.size());
  const HalfTransmittanceLevel level =
      FindHalfTransmittanceLevel(field, {glm::dvec3(-1), glm::dvec3(1)}, {}, 2000, 1);
  EXPECT_EQ(level.rays, 2000u);
  EXPECT_GT(level.opaque_rays, 1000u);
  // Half transmittance is at a depth of sqrt(2 ln 2 / 200) = 0.083 for head-on rays, less for
  // grazing ones.
  EXPECT_GT(level.isovalue / 200, 0.03);
  EXPECT_LT(level.isovalue / 200, 0.11);
}

TEST(HalfTransmittanceLevel, RefusesAFieldThatStopsNoRay) {
  RadianceField field = Ramp(1e-4, 1);
  EXPECT_THROW(FindHalfTransmittanceLevel(field, {glm::dvec3(-1), glm::dvec3(1)}, {}, 200, 1),
               DataError);
}

}  // namespace
}  // namespace tetrec
