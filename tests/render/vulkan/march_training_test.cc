// The march renderer learns: steps, state, scores.
#include "render/reference/render_picture.h"
#include "render/scenes.h"
#include "render/targets.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetrec::test {
namespace {

constexpr int kTrainingWidth = 20, kTrainingHeight = 14;

std::vector<RenderView> FourViews() {
  std::vector<RenderView> views;
  for (const glm::dvec3 eye : {glm::dvec3(1.7, -1.1, -1.0), glm::dvec3(-1.5, 1.0, -0.5),
                               glm::dvec3(0.1, 0.4, 2.5), glm::dvec3(0.1, 0.4, 0.5)}) {
    views.push_back(LookAt(eye, {0.0, 0.35, 0.65}, kTrainingWidth, kTrainingHeight));
  }
  return views;
}

std::vector<TargetImage> TargetsOf(ProbedRenderer& renderer, const std::vector<RenderView>& views) {
  std::vector<TargetImage> targets;
  for (const RenderView& view : views) targets.push_back(TargetOf(renderer.Render(view, 1)));
  return targets;
}

// The target of a channel of a pixel, and the colour of a ray on `background`.
glm::vec3 Residual(const glm::vec4& ray, uint32_t rgba8, const glm::vec3& background) {
  const glm::vec3 rgb(float(rgba8 & 255), float(rgba8 >> 8 & 255), float(rgba8 >> 16 & 255));
  const float alpha = float(rgba8 >> 24) / 255.0f;
  return glm::vec3(ray) + std::exp(-ray.a) * background -
         (rgb / 255.0f + (1.0f - alpha) * background);
}

// Calls body(residual, optical depth) for every ray through the pixels of all views.
template <class Body>
void ForEachResidual(ProbedRenderer& renderer, const std::vector<RenderView>& views,
                     const std::vector<TargetImage>& targets, const glm::vec3& background,
                     const Body& body) {
  for (size_t v = 0; v < views.size(); ++v) {
    const auto blocks = AllBlocks(views[v].camera);
    const auto rays = renderer.MarchBlocks(views[v], blocks);
    for (size_t r = 0; r < rays.size(); ++r) {
      const size_t pixel = (blocks[r / 8].y + r % 8 / 4) * kTrainingWidth + blocks[r / 8].x + r % 4;
      body(glm::dvec3(Residual(rays[r], targets[v].rgba8[pixel], background)), double(rays[r].a));
    }
  }
}

TEST_F(RendererTest, WhatIsNotJudgedHasNoLoss) {
  ProbedRenderer& renderer = MakeRenderer();
  const std::vector<RenderView> views = FourViews();
  renderer.SetField(RandomField(40, 51, 6.0f));
  std::vector<TargetImage> targets = TargetsOf(renderer, views);
  const std::vector<RayBlock> blocks = BlocksOf(views);
  for (const LossKind loss : {LossKind::kL2, LossKind::kL1}) {
    const auto result_with = [&](uint32_t rgba8) {
      for (TargetImage& target : targets) {
        std::fill(target.rgba8.begin(), target.rgba8.end(), rgba8);
      }
      renderer.SetTargets(views, targets);
      StepResult result;
      // A step returns the result of the step before last.
      for (int i = 0; i < 3; ++i) {
        result =
            renderer.Step({.blocks = blocks, .loss = loss, .background_srgb = glm::vec3(0.5f)}, {});
      }
      return result;
    };
    EXPECT_GT(result_with(0).loss, 0);
    EXPECT_EQ(result_with(kNotJudgedTarget).loss, 0);
    EXPECT_EQ(result_with(kNotJudgedTarget).squared_error, 0);
  }
}

TEST_F(RendererTest, StepsLowerTheLoss) {
  for (LossKind loss : {LossKind::kL2, LossKind::kL1}) {
    ProbedRenderer& renderer = MakeRenderer();
    const RadianceField truth = RandomField(40, 51, 6.0f);
    renderer.SetField(truth);
    const std::vector<RenderView> views = FourViews();
    renderer.SetTargets(views, TargetsOf(renderer, views));
    renderer.SetField(ConstantField(truth.mesh, 0.2f, glm::vec3(0.5f)));
    const std::vector<RayBlock> blocks = BlocksOf(views);
    std::vector<double> losses;
    for (uint32_t i = 1; i <= 200; ++i) {
      losses.push_back(renderer
                           .Step({.blocks = blocks,
                                  .loss = loss,
                                  .background_srgb = glm::vec3(i % 3 == 0, i % 2, 0.5f),
                                  .seed = i},
                                 {.step = i})
                           .loss);
    }
    EXPECT_EQ(losses[0], 0.0);
    EXPECT_LT(losses.back(), (loss == LossKind::kL2 ? 0.02 : 0.2) * losses[2]);
    for (double value : losses) ASSERT_TRUE(std::isfinite(value));
  }
}

// Compares the loss that a step reports with the one summed here from rays and targets.
TEST_F(RendererTest, StepReportsTheLossOfItsRays) {
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetField(RandomField(40, 52, 6.0f));
  const std::vector<RenderView> views = FourViews();
  const std::vector<TargetImage> targets = TargetsOf(renderer, views);
  renderer.SetTargets(views, targets);
  renderer.SetField(RandomField(40, 53, 3.0f));
  const std::vector<RayBlock> blocks = BlocksOf(views);
  const glm::vec3 background(0.1f, 0.7f, 0.4f);
  double squares = 0, absolutes = 0;
  ForEachResidual(renderer, views, targets, background, [&](const glm::dvec3& residual, double) {
    squares += glm::dot(residual, residual);
    absolutes += glm::dot(glm::abs(residual), glm::dvec3(1.0));
  });
  const double count = 3.0 * double(blocks.size()) * kRaysPerBlock;
  const TrainingBatch batch{.blocks = blocks, .loss = LossKind::kL1, .background_srgb = background};
  renderer.Step(batch, kStandingUpdate);
  renderer.Step(batch, kStandingUpdate);
  const StepResult first = renderer.Step(batch, kStandingUpdate);
  EXPECT_NEAR(first.loss, absolutes / count, 1e-5 * first.loss);
  EXPECT_NEAR(first.squared_error, squares / count, 1e-5 * first.squared_error);
}

// Adam's first step moves every parameter by its rate against the sign of its gradient.
TEST_F(RendererTest, FirstStepMovesEveryParameterAgainstItsGradient) {
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  renderer.SetField(RandomField(40, 54, 6.0f));
  const std::vector<RenderView> views = FourViews();
  const std::vector<TargetImage> targets = TargetsOf(renderer, views);
  renderer.SetTargets(views, targets);
  const RadianceField field = RandomField(40, 55, 3.0f);
  renderer.SetField(field);
  const glm::vec3 background(0.1f, 0.7f, 0.4f);
  std::vector<glm::dvec3> color(field.density.size());
  std::vector<double> density(field.density.size());
  for (size_t v = 0; v < views.size(); ++v) {
    const ReferenceImage image = RenderReference(field, views[v], 0.0);
    std::vector<glm::dvec4> g;
    for (size_t i = 0; i < image.color_srgb.size(); ++i) {
      const glm::vec4 ray(glm::vec3(image.color_srgb[i]), float(image.optical_depth[i]));
      const glm::dvec3 residual(Residual(ray, targets[v].rgba8[i], background));
      g.emplace_back(2.0 * residual, 2.0 * glm::dot(residual, glm::dvec3(background)));
    }
    const ReferenceGradient gradient = BackpropagateReference(field, views[v], g, 0.0);
    for (size_t i = 0; i < color.size(); ++i) {
      color[i] += gradient.color_srgb[i];
      density[i] += gradient.density[i];
    }
  }
  const std::vector<RayBlock> blocks = BlocksOf(views);
  renderer.Step({.blocks = blocks, .background_srgb = background}, {});
  const std::vector<glm::vec4> parameters = StandardRows(renderer.ReadState().parameters);
  const AdamUpdate adam;
  for (size_t v = 0; v < color.size(); ++v) {
    if (std::abs(color[v].g) > 1e-3) {
      const double moved = field.color_srgb[v].g - std::copysign(adam.color_rate, color[v].g);
      EXPECT_NEAR(parameters[v].g, std::clamp(moved, 0.0, 1.0), 1e-5);
    }
    // Smaller ones are close to Adam's epsilon.
    if (std::abs(field.density[v] * density[v]) > 1e-3) {
      EXPECT_NEAR(parameters[v].a,
                  std::log(field.density[v]) - std::copysign(adam.density_rate, density[v]), 1e-4);
    }
  }
}

TEST_F(RendererTest, StateComesBackAsItWasSet) {
  ExpectStateComesBack(MakeRenderer(), RandomBoxMesh(40, 56), {});
}

// A step after a round trip has the same result as one without it, up to the order of float sums.
TEST_F(RendererTest, TrainingGoesOnFromAStateReadBack) {
  const std::vector<RenderView> views = FourViews();
  const std::vector<RayBlock> blocks = BlocksOf(views);
  const RadianceField start = RandomField(40, 57, 3.0f);
  std::vector<std::vector<glm::vec4>> ends;
  for (bool with_round_trip : {false, true}) {
    ProbedRenderer& renderer = MakeRenderer();
    renderer.SetField(RandomField(40, 58, 6.0f));
    renderer.SetTargets(views, TargetsOf(renderer, views));
    renderer.SetField(start);
    for (uint32_t i = 1; i <= 6; ++i) {
      renderer.Step({.blocks = blocks}, {.step = i});
      if (with_round_trip && i == 3) renderer.SetState(start.mesh, renderer.ReadState());
    }
    ends.push_back(StandardRows(renderer.ReadState().parameters));
  }
  double worst = 0;
  for (size_t v = 0; v < ends[0].size(); ++v) {
    worst = std::max(worst, double(glm::distance(glm::vec3(ends[0][v]), glm::vec3(ends[1][v]))));
  }
  EXPECT_LT(worst, 2e-3);
}

// Colours that an image cannot show would let bright surfaces shine through dark fog.
TEST_F(RendererTest, StepsKeepColorsInsideThePicturesRange) {
  ProbedRenderer& renderer = MakeRenderer();
  const std::vector<RenderView> views = FourViews();
  const RadianceField field = RandomField(40, 56, 6.0f);
  renderer.SetField(field);
  std::vector<TargetImage> targets = TargetsOf(renderer, views);
  for (TargetImage& target : targets) {
    for (size_t i = 0; i < target.rgba8.size(); ++i) target.rgba8[i] = i % 2 ? ~0u : 0xFF000000u;
  }
  renderer.SetTargets(views, targets);
  const std::vector<RayBlock> blocks = BlocksOf(views);
  for (uint32_t i = 1; i <= 20; ++i) {
    renderer.Step({.blocks = blocks}, {.step = i, .color_rate = 0.3});
  }
  float least = 1, most = 0;
  for (const glm::vec4& row : StandardRows(renderer.ReadState().parameters)) {
    for (int c = 0; c < 3; ++c) {
      least = std::min(least, row[c]);
      most = std::max(most, row[c]);
    }
  }
  EXPECT_EQ(least, 0.0f);
  EXPECT_EQ(most, 1.0f);
}

TEST_F(RendererTest, DensityDecayPullsSeenVerticesTowardsEmptyUnlessTheyAreToBeKept) {
  const RadianceField field = RandomField(40, 57, 3.0f);
  // One view from above the centre of the box sees some vertices, but not those at its edges.
  const std::vector<RenderView> views = {LookAt({0.0, 0.35, 2.5}, {0.0, 0.35, 0.65}, 8, 8, 8.0)};
  const std::vector<RayBlock> blocks = BlocksOf(views);
  // Half of the vertices are kept once they have this density.
  constexpr float kKept = 1.5f;
  std::vector<RowRates> rates(field.mesh.positions.size());
  for (size_t v = 0; v < rates.size(); v += 2) rates[v].kept_density = kKept;
  std::vector<std::vector<glm::vec4>> ends;
  for (double decay : {0.0, 0.5}) {
    ProbedRenderer& renderer = MakeRenderer();
    renderer.SetField(ConstantField(field.mesh, 0.7f, glm::vec3(0.9f)));
    const std::vector<TargetImage> targets = TargetsOf(renderer, views);
    renderer.SetTargets(views, targets);
    renderer.SetField(field);
    renderer.SetRowRates(rates);
    renderer.Step({.blocks = blocks}, {.density_rate = 0.1, .density_decay = decay});
    ends.push_back(StandardRows(renderer.ReadState().parameters));
  }
  int decayed = 0, kept = 0, unseen = 0;
  for (size_t v = 0; v < ends[0].size(); ++v) {
    const float pulled = ends[0][v].a - ends[1][v].a;
    const bool moved = std::abs(ends[0][v].a - std::log(field.density[v])) > 1e-4f;
    if (moved && v % 2 == 0 && ends[0][v].a >= std::log(kKept)) {
      EXPECT_NEAR(pulled, 0.0f, 1e-4f) << v;
      ++kept;
    } else if (moved) {
      EXPECT_NEAR(pulled, 0.05f, 1e-4f) << v;
      ++decayed;
    } else if (pulled == 0.0f) {
      ++unseen;
    }
  }
  EXPECT_GT(decayed, 2);
  EXPECT_GT(kept, 2);
  EXPECT_GT(unseen, 4);
}

TEST_F(RendererTest, ScoresShareOutTheSquaredResidualOfEveryRay) {
  for (bool float_atomics : {true, false}) {
    ProbedRenderer& renderer = MakeRenderer({.device = {.float_atomics = float_atomics}});
    renderer.SetField(RandomField(40, 59, 6.0f));
    const std::vector<RenderView> views = FourViews();
    const std::vector<TargetImage> targets = TargetsOf(renderer, views);
    renderer.SetTargets(views, targets);
    renderer.SetField(RandomField(40, 60, 3.0f));
    const glm::vec3 background(0.1f, 0.7f, 0.4f);
    double expected = 0, residuals = 0;
    ForEachResidual(renderer, views, targets, background,
                    [&](const glm::dvec3& residual, double depth) {
                      residuals += glm::dot(residual, residual);
                      expected += glm::dot(residual, residual) * -std::expm1(-depth);
                    });
    const std::vector<RayBlock> blocks = BlocksOf(views);
    renderer.ClearScores();
    renderer.AddScores({.blocks = blocks, .background_srgb = background},
                       ScoreKind::kSquaredResidual);
    const std::vector<float> scores = renderer.ReadScores().errors;
    const double sum = std::accumulate(scores.begin(), scores.end(), 0.0);
    EXPECT_LE(sum, expected * (1.0 + 1e-4));
    // Shares below 1e-3 are omitted; a ray meets at most 20 tets.
    EXPECT_GE(sum, expected - 20 * 1e-3 * residuals);
    EXPECT_GT(sum, 0.9 * expected);
    renderer.ClearScores();
    EXPECT_EQ(renderer.ReadScores().errors, std::vector<float>(scores.size(), 0.0f));
    EXPECT_EQ(renderer.ReadScores().light, std::vector<float>(scores.size(), 0.0f));
  }
}

}  // namespace
}  // namespace tetrec::test
