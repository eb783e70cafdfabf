// The D-SSIM part of the loss: its value against the eval module, its gradient against finite
// differences, and the kernels against both.
#include "render/reference/dssim.h"

#include "eval/image_metrics.h"
#include "render/reference/render_picture.h"
#include "render/scenes.h"
#include "render/targets.h"
#include "shared/ssim.glsl.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tetrec::test {
namespace {

using Pixels = std::vector<glm::dvec3>;

// Smooth if `noise` is small; flat if `contrast` is 0.
Pixels RandomPixels(int width, int height, uint32_t seed, double contrast, double noise) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  const glm::dvec3 base(unit(random), unit(random), unit(random));
  Pixels pixels;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double wave = contrast * (0.5 + 0.5 * std::sin(0.7 * x + 0.4 * y + 5.0 * base.r));
      pixels.push_back(glm::mix(base, glm::dvec3(wave), contrast) +
                       noise * glm::dvec3(unit(random), unit(random), unit(random)));
    }
  }
  return pixels;
}

TEST(Dssim, WeightsOfAWindowSumToOne) {
  double sum = 0;
  for (int d = -kSsimReach; d <= kSsimReach; ++d) sum += SsimWindowWeight(double(d));
  EXPECT_NEAR(sum, 1.0, 1e-15);
}

// The eval module pads images with zeros. In a black frame of 10 pixels its windows centred in the
// outer 5 see black in both images, so SSIM is 1 there; the others are full.
TEST(Dssim, IsTheEvalModulesSsimOfTheFullWindows) {
  constexpr int kWidth = 37, kHeight = 31, kFrame = 10;
  std::mt19937 random(5);
  std::uniform_int_distribution<int> byte(0, 255);
  Image images[2];
  Pixels pixels[2];
  for (int i = 0; i < 2; ++i) {
    images[i] = {kWidth, kHeight, 3, {}};
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        const bool black = std::min({x, y, kWidth - 1 - x, kHeight - 1 - y}) < kFrame;
        glm::dvec3 color(0.0);
        for (int c = 0; c < 3; ++c) {
          const int value = black ? 0 : 60 * c + (x + y) * 2 % 60 + byte(random) / 4;
          images[i].pixels.push_back(uint8_t(value));
          color[c] = value / 255.0;
        }
        pixels[i].push_back(color);
      }
    }
  }
  const double all = double(kWidth) * kHeight;
  const double full = double(kWidth - 2 * kSsimReach) * (kHeight - 2 * kSsimReach);
  const double ssim = (Ssim(images[0], images[1]) * all - (all - full)) / full;
  EXPECT_LT(ssim, 0.95);
  EXPECT_NEAR(EvaluateDssim(pixels[0], pixels[1], kWidth, kHeight).value, 0.5 * (1.0 - ssim),
              1e-12);
}

TEST(Dssim, EqualPicturesHaveNoneAndNoGradient) {
  const Pixels pixels = RandomPixels(14, 12, 1, 0.5, 0.3);
  const Dssim dssim = EvaluateDssim(pixels, pixels, 14, 12);
  EXPECT_NEAR(dssim.value, 0.0, 1e-15);
  for (const glm::dvec3& g : dssim.gradient) EXPECT_LT(glm::length(g), 1e-15);
}

TEST(Dssim, WhatIsNotJudgedHasNoPart) {
  constexpr int kWidth = 14, kHeight = 12;
  Pixels shown = RandomPixels(kWidth, kHeight, 1, 0.5, 0.3),
         wanted = RandomPixels(kWidth, kHeight, 2, 0.5, 0.3);
  const Dssim all = EvaluateDssim(shown, wanted, kWidth, kHeight);
  const size_t hidden = 5 * kWidth + 6;
  shown[hidden] = wanted[hidden] = glm::dvec3(kNotJudged);
  const Dssim rest = EvaluateDssim(shown, wanted, kWidth, kHeight);
  EXPECT_EQ(rest.gradient[hidden], glm::dvec3(0.0));
  EXPECT_GT(glm::length(all.gradient[hidden]), 0);
  EXPECT_GT(glm::length(rest.gradient[hidden + 1]), 0);
  for (size_t i = 0; i < shown.size(); ++i) {
    if (i != hidden) shown[i] = wanted[i];
  }
  EXPECT_NEAR(EvaluateDssim(shown, wanted, kWidth, kHeight).value, 0, 1e-15);
}

// Fourth-order differences: rounding 1e-16 / step, truncation step^4 / C2^2.
TEST(Dssim, GradientAgreesWithDifferences) {
  constexpr int kWidth = 14, kHeight = 13;
  struct Case {
    double contrast, noise;
  };
  for (const Case& c : {Case{0.8, 0.2}, Case{0.0, 0.5}, Case{0.0, 1e-3}}) {
    Pixels shown = RandomPixels(kWidth, kHeight, 2, c.contrast, c.noise);
    const Pixels wanted = RandomPixels(kWidth, kHeight, 3, c.contrast, c.noise);
    const Dssim dssim = EvaluateDssim(shown, wanted, kWidth, kHeight);
    double largest = 0;
    for (const glm::dvec3& g : dssim.gradient) largest = std::max(largest, glm::length(g));
    for (size_t pixel = 0; pixel < shown.size(); pixel += 5) {
      double& value = shown[pixel][int(pixel % 3)];
      const double before = value, step = 2e-4;
      const auto at = [&](double shift) {
        value = before + shift;
        const double result = EvaluateDssim(shown, wanted, kWidth, kHeight).value;
        value = before;
        return result;
      };
      const double slope =
          (8 * (at(step) - at(-step)) - (at(2 * step) - at(-2 * step))) / (12 * step);
      EXPECT_NEAR(dssim.gradient[pixel][int(pixel % 3)], slope, 1e-7 * largest)
          << "pixel " << pixel << ", contrast " << c.contrast << ", noise " << c.noise;
    }
  }
}

constexpr int kDssimWidth = 20, kDssimHeight = 14;
const glm::vec3 kDssimBackground(0.1f, 0.7f, 0.4f);

std::vector<RenderView> SomeViews() {
  return {LookAt({1.7, -1.1, -1.0}, {0.0, 0.35, 0.65}, kDssimWidth, kDssimHeight),
          LookAt({0.1, 0.4, 0.5}, {0.0, 0.35, 0.65}, kDssimWidth, kDssimHeight)};
}

// The expected result of a step: loss, and the gradient with respect to colour and log density of
// each vertex.
struct Expected {
  double loss = 0;
  std::vector<glm::dvec4> gradient;
};

// One tile per view: blocks [0, columns) x [0, rows) of its image.
Expected ExpectedOf(const RadianceField& field, const std::vector<RenderView>& views,
                    const std::vector<TargetImage>& targets, const TileShape& tiles, LossKind kind,
                    double weight) {
  const int width = int(tiles.columns) * kRayBlockWidth, height = int(tiles.rows) * kRayBlockHeight;
  const double share = 1.0 / double(views.size()), per_ray = share / (3.0 * width * height);
  const glm::dvec3 background(kDssimBackground);
  Expected expected{0, std::vector<glm::dvec4>(field.density.size(), glm::dvec4(0.0))};
  for (size_t v = 0; v < views.size(); ++v) {
    const ReferenceImage image = RenderReference(field, views[v], 0.0);
    Pixels shown, wanted;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const size_t pixel = size_t(y) * kDssimWidth + size_t(x);
        const uint32_t rgba = targets[v].rgba8[pixel];
        const glm::dvec3 rgb(rgba & 255, rgba >> 8 & 255, rgba >> 16 & 255);
        shown.push_back(image.color_srgb[pixel] +
                        std::exp(-image.optical_depth[pixel]) * background);
        wanted.push_back(rgb / 255.0 + (1.0 - (rgba >> 24) / 255.0) * background);
        if (rgba == kNotJudgedTarget) shown.back() = wanted.back() = glm::dvec3(kNotJudged);
      }
    }
    const Dssim dssim = EvaluateDssim(shown, wanted, width, height);
    expected.loss += weight * share * dssim.value;
    std::vector<glm::dvec4> by_pixel(size_t(kDssimWidth) * kDssimHeight, glm::dvec4(0.0));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const size_t i = size_t(y) * size_t(width) + size_t(x);
        const glm::dvec3 residual = shown[i] - wanted[i];
        const bool l1 = kind == LossKind::kL1;
        const glm::dvec3 losses = l1 ? glm::abs(residual) : residual * residual;
        expected.loss += (1.0 - weight) * per_ray * (losses.r + losses.g + losses.b);
        const glm::dvec3 g =
            (1.0 - weight) * per_ray * (l1 ? glm::sign(residual) : 2.0 * residual) +
            weight * share * dssim.gradient[i];
        by_pixel[size_t(y) * kDssimWidth + size_t(x)] = glm::dvec4(g, glm::dot(g, background));
      }
    }
    const ReferenceGradient gradient = BackpropagateReference(field, views[v], by_pixel, 0.0);
    for (size_t i = 0; i < expected.gradient.size(); ++i) {
      expected.gradient[i] +=
          glm::dvec4(gradient.color_srgb[i], field.density[i] * gradient.density[i]);
    }
  }
  return expected;
}

// Adam's first moment after its first step is (1 - beta1) times the gradient.
void ExpectStep(ProbedRenderer& renderer, const std::vector<RenderView>& views,
                const TileShape& tiles, LossKind kind, float weight) {
  const RadianceField field = RandomField(40, 55, 3.0f);
  const std::vector<TargetImage> targets = RandomTargets(views.size(), kDssimWidth, kDssimHeight);
  renderer.SetTargets(views, targets);
  renderer.SetField(field);
  std::vector<RayBlock> blocks;
  for (uint32_t v = 0; v < views.size(); ++v) {
    for (uint32_t row = 0; row < tiles.rows; ++row) {
      for (uint32_t column = 0; column < tiles.columns; ++column) {
        blocks.push_back({v, column * kRayBlockWidth, row * kRayBlockHeight});
      }
    }
  }
  const TrainingBatch step{.blocks = blocks,
                           .loss = kind,
                           .dssim_weight = weight,
                           .tiles = tiles,
                           .background_srgb = kDssimBackground};
  renderer.Step(step, kStandingUpdate);
  const std::vector<glm::vec4> moments = StandardRows(renderer.ReadState().first_moment);
  renderer.Step(step, kStandingUpdate);
  const StepResult first = renderer.Step(step, kStandingUpdate);
  const Expected expected = ExpectedOf(field, views, targets, tiles, kind, double(weight));
  // The error of sums of some hundred floats near 1.
  EXPECT_NEAR(first.loss, expected.loss, 2e-6);
  double error = 0, size = 0;
  for (size_t v = 0; v < moments.size(); ++v) {
    const glm::dvec4 gradient = glm::dvec4(moments[v]) / double(1.0f - kStandingUpdate.beta1);
    error += glm::dot(gradient - expected.gradient[v], gradient - expected.gradient[v]);
    size += glm::dot(expected.gradient[v], expected.gradient[v]);
  }
  // Variances are differences of means of squares: 1e-7 over C2 = 1e-3.
  EXPECT_LT(std::sqrt(error / size), 1e-4);
}

class EveryRenderersDssim : public EveryRendererTest {};

TEST_P(EveryRenderersDssim, OfOneTileHasTheReferencesLossAndGradient) {
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  const std::vector<RenderView> views = {SomeViews()[0]};
  ExpectStep(renderer, views, {5, 7}, LossKind::kL2, 0.3f);
  ExpectStep(renderer, views, {3, 6}, LossKind::kL1, 0.2f);
}

INSTANTIATE_TEST_SUITE_P(, EveryRenderersDssim, kEveryRenderer, RendererName);

using DssimRenderer = RendererTest;

TEST_F(DssimRenderer, OfSeveralTilesHasTheReferencesLossAndGradient) {
  for (bool deterministic : {false, true}) {
    ProbedRenderer& renderer =
        MakeRenderer({.stop_transmittance = 0.0f, .deterministic = deterministic});
    ExpectStep(renderer, SomeViews(), {5, 6}, LossKind::kL1, 0.2f);
    ExpectStep(renderer, SomeViews(), {3, 7}, LossKind::kL2, 1.0f);
    EXPECT_EQ(renderer.counts().clamped_addends, 0u);
  }
}

TEST_F(DssimRenderer, RefusesTilesThatHoldNoWindowOrLeaveTheirPicture) {
  ProbedRenderer& renderer = MakeRenderer();
  const std::vector<RenderView> views = SomeViews();
  renderer.SetTargets(views, RandomTargets(views.size(), kDssimWidth, kDssimHeight));
  renderer.SetField(RandomField(40, 55, 3.0f));
  const std::vector<RayBlock> blocks = AllBlocks(views[0].camera);
  std::vector<RayBlock> moved = blocks;
  for (RayBlock& block : moved) block.x += 4;
  const auto step = [&](const std::vector<RayBlock>& of, const TileShape& tiles) {
    renderer.Step({.blocks = of, .dssim_weight = 0.5f, .tiles = tiles}, {});
  };
  EXPECT_THROW(step(blocks, {0, 0}), BugError);
  EXPECT_THROW(step(blocks, {35, 1}), BugError);
  EXPECT_THROW(step(blocks, {4, 7}), BugError);
  EXPECT_THROW(step(moved, {5, 7}), BugError);
  step(blocks, {5, 7});
}

}  // namespace
}  // namespace tetrec::test
