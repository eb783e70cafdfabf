// When degrees of harmonics are unlocked and judged, and what is left of one that is dropped.
#include "optimize/harmonics.h"

#include "field/field_state.h"
#include "geometry/look_at.h"
#include "render/seen_colors.h"

#include <gtest/gtest.h>

#include <random>

namespace tetrec::test {
namespace {

RadianceField OneTet(int degree) {
  RadianceField field;
  field.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  field.mesh.tets = {{0, 1, 2, 3}};
  field.mesh.neighbors = {glm::uvec4(kNoTet)};
  field.density.assign(4, 1.0f);
  field.color_srgb.assign(4, glm::vec3(0.5f));
  if (degree == 0) return field;
  AttributeValues harmonics{HarmonicsAttribute(degree), {}};
  std::mt19937 random(5);
  std::uniform_real_distribution<float> small(-0.05f, 0.05f);
  for (int i = 0; i < 4 * harmonics.attribute.components; ++i) {
    harmonics.values.push_back(small(random));
  }
  field.others = {std::move(harmonics)};
  return field;
}

// Cameras of training photos that all look at one place.
Scene ViewsFrom(const std::vector<glm::dvec3>& eyes, const glm::dvec3& target) {
  Scene scene;
  scene.cameras = {{8, 8, 8.0, 8.0, 4.0, 4.0}};
  for (const glm::dvec3& eye : eyes) {
    View view;
    view.cam_from_world = CamLookingAt(eye, target, glm::dvec3(0, 0, 1));
    scene.views.push_back(view);
  }
  return scene;
}

// The steps of a run, in order, in which every judged degree stays, or none does.
std::vector<HarmonicsStep> StepsOf(HarmonicsChoice choice, bool stays, size_t photos = 100) {
  std::vector<HarmonicsStep> steps;
  HarmonicsState state;
  for (double progress = 0; progress < 1; progress += 0.01) {
    const HarmonicsStep step = NextHarmonicsStep(choice, photos, state, progress);
    if (step == HarmonicsStep::kNone) continue;
    steps.push_back(step);
    if (step == HarmonicsStep::kUnlock) ++state.unlocked;
    if (step == HarmonicsStep::kJudge) state.judged = state.unlocked, state.closed = !stays;
  }
  return steps;
}

TEST(Harmonics, StayIfThePicturesGainVisibly) {
  EXPECT_TRUE(IsWorthHarmonics(28.1, 28.0));
  EXPECT_FALSE(IsWorthHarmonics(28.04, 28.0));
  EXPECT_FALSE(IsWorthHarmonics(28.0, 28.1));
  EXPECT_FALSE(IsWorthHarmonics(37.2, 37.0));  // less than one step of 8 bits
  EXPECT_TRUE(IsWorthHarmonics(38.0, 37.0));
}

TEST(Harmonics, AreUnlockedUpToTheChosenDegree) {
  using enum HarmonicsStep;
  using Steps = std::vector<HarmonicsStep>;
  EXPECT_EQ(StepsOf(HarmonicsChoice::kNone, true), Steps{});
  EXPECT_EQ(StepsOf(HarmonicsChoice::kDegree2, true), (Steps{kUnlock, kUnlock}));
  EXPECT_EQ(StepsOf(HarmonicsChoice::kAuto, true),
            (Steps{kUnlock, kJudge, kUnlock, kJudge, kUnlock}));
  EXPECT_EQ(StepsOf(HarmonicsChoice::kAuto, false), (Steps{kUnlock, kJudge}));
}

TEST(Harmonics, HaveNoMoreFunctionsThanThereArePhotosUnlessTheyAreAskedFor) {
  using enum HarmonicsStep;
  using Steps = std::vector<HarmonicsStep>;
  EXPECT_EQ(HighestDegree(HarmonicsChoice::kAuto, 3), 0u);
  EXPECT_EQ(HighestDegree(HarmonicsChoice::kAuto, 4), 1u);
  EXPECT_EQ(HighestDegree(HarmonicsChoice::kAuto, 15), 2u);
  EXPECT_EQ(HighestDegree(HarmonicsChoice::kAuto, 1000), 3u);
  EXPECT_EQ(StepsOf(HarmonicsChoice::kAuto, true, 15), (Steps{kUnlock, kJudge, kUnlock, kJudge}));
  EXPECT_EQ(StepsOf(HarmonicsChoice::kDegree3, true, 4), (Steps{kUnlock, kUnlock, kUnlock}));
}

TEST(Harmonics, LeaveTheColoursThatASingleViewSaw) {
  const RadianceField field = OneTet(3);
  const glm::dvec3 eye(3.0, -2.0, 1.0);
  // The other camera looks away.
  Scene scene = ViewsFrom({eye, {-2.0, 3.0, 0.5}}, glm::dvec3(0.2));
  scene.views[1].cam_from_world =
      CamLookingAt({-2.0, 3.0, 0.5}, glm::dvec3(-4.0, 6.0, 1.0), glm::dvec3(0, 0, 1));
  FieldState state = StateOf(field);
  for (int degree = 2; degree >= 0; --degree) {
    state = WithoutHighestDegree(field.mesh, state, PhotoSight(scene));
    EXPECT_EQ(state.layout.HarmonicsDegree(), degree);
    const RadianceField seen = FieldSeenFrom(FieldOf(field.mesh, state), eye);
    const RadianceField expected = FieldSeenFrom(field, eye);
    for (size_t v = 0; v < 4; ++v) {
      EXPECT_LT(glm::length(seen.color_srgb[v] - expected.color_srgb[v]), 1e-6f);
    }
  }
}

TEST(Harmonics, OfAHigherDegreeStartAtZeroAndKeepTheRest) {
  const FieldState state = StateOf(OneTet(1));
  const FieldState more = WithHarmonics(state, 3);
  EXPECT_EQ(more.layout.Components(), kStandardComponents + 45);
  EXPECT_EQ(more.parameters.size(), 4 * size_t(more.layout.Components()));
  EXPECT_EQ(WithHarmonics(more, 1).parameters, state.parameters);
  const glm::dvec3 eye(2.0, 1.0, -1.0);
  EXPECT_EQ(FieldSeenFrom(FieldOf(OneTet(1).mesh, more), eye).color_srgb,
            FieldSeenFrom(OneTet(1), eye).color_srgb);
}

TEST(Harmonics, MeanNothingFromWithinTheirVertex) {
  const RadianceField field = OneTet(2);
  EXPECT_EQ(FieldSeenFrom(field, glm::dvec3(0.0)).color_srgb[0], field.color_srgb[0]);
}

}  // namespace
}  // namespace tetrec::test
