// View-dependent colour: images and gradients of all renderers.
#include "field/extra_attribute.h"
#include "render/reference_loss.h"
#include "render/scenes.h"
#include "render/seen_colors.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec::test {
namespace {

constexpr int kHarmonicsWidth = 24, kHarmonicsHeight = 18;

// Coefficients of all functions, as large as the colours.
RadianceField ShinyField(int points, uint32_t seed, int degree,
                         FieldStorage storage = FieldStorage::kVertex) {
  RadianceField field = RandomField(points, seed, 6.0f, storage);
  AttributeValues harmonics{HarmonicsAttribute(degree), {}};
  std::mt19937 random(seed + 2);
  std::normal_distribution<float> normal(0.0f, 0.4f);
  const size_t count = RowCount(field) * size_t(harmonics.attribute.components);
  for (size_t i = 0; i < count; ++i) harmonics.values.push_back(normal(random));
  field.others = {std::move(harmonics)};
  return field;
}

class HarmonicsTest : public EveryRendererTest {
 protected:
  // Of the field and random pictures.
  ProbedRenderer& MakeLearner(const RadianceField& field, RendererOptions options = {}) {
    options.stop_transmittance = 0.0f;
    ProbedRenderer& renderer = MakeRenderer(options);
    GiveTask(renderer, field);
    return renderer;
  }

  void GiveTask(ProbedRenderer& renderer, const RadianceField& field) const {
    renderer.SetField(field);
    std::mt19937 random(41);
    std::vector<TargetImage> targets;
    for (size_t v = 0; v < views_.size(); ++v) {
      targets.push_back({kHarmonicsWidth, kHarmonicsHeight, {}});
      for (int i = 0; i < kHarmonicsWidth * kHarmonicsHeight; ++i) {
        targets.back().rgba8.push_back(uint32_t(random()) & 0x7F7F7F7Fu);
      }
    }
    renderer.SetTargets(views_, targets);
  }

  // Of more views than the kernels take at once, in this order: 1, 0, 2, 3, 4; of one view if the
  // renderer takes tiles.
  std::vector<RayBlock> Blocks(const TrainingRenderer& renderer) const {
    std::vector<RayBlock> blocks = AllBlocks(views_[1].camera, 1);
    if (renderer.NeedsTiles()) return blocks;
    for (const uint32_t v : {0u, 2u, 3u, 4u}) {
      const std::vector<RayBlock> more = AllBlocks(views_[v].camera, v);
      blocks.insert(blocks.end(), more.begin(), more.end());
    }
    return blocks;
  }

  GradientSums Gradients(ProbedRenderer& renderer) const {
    const std::vector<RayBlock> blocks = Blocks(renderer);
    renderer.Forward({.blocks = blocks});
    renderer.Backward(GradientParts::kColorDensity);
    return renderer.TakeGradients();
  }

  std::vector<RenderView> FiveViews() const {
    std::vector<RenderView> views = ThreeViews(kHarmonicsWidth, kHarmonicsHeight);
    for (const size_t v : {0u, 1u}) {
      views.push_back(views[v]);
      views.back().cam_from_world.translation += glm::dvec3(0.2, 0.1, 0.1);
    }
    return views;
  }

  std::vector<RenderView> views_ = FiveViews();
};

INSTANTIATE_TEST_SUITE_P(, HarmonicsTest, kEveryRenderer, RendererName);

TEST_P(HarmonicsTest, PicturesAreThoseOfTheReference) {
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  for (int degree = 1; degree <= kMostHarmonicsDegree; ++degree) {
    for (const FieldStorage storage : {FieldStorage::kVertex, FieldStorage::kCell}) {
      const RadianceField field = ShinyField(40, 7, degree, storage);
      renderer.SetField(field);
      for (const RenderView& view : views_) {
        const RenderedImage image = renderer.Render(view, 1);
        const ReferenceImage expected = RenderReference(field, view, 0.0);
        for (size_t i = 0; i < image.color_srgb.size(); ++i) {
          // As without harmonics: floats against doubles, a little more for the sums of the basis.
          EXPECT_LT(glm::length(glm::dvec3(image.color_srgb[i]) - expected.color_srgb[i]), 2e-4);
        }
      }
    }
  }
}

// Of five views: gradients of all views meet in one row, with harmonics and without.
TEST_P(HarmonicsTest, GradientsAreThoseOfTheReference) {
  for (const RadianceField& field :
       {ShinyField(30, 11, 3), ShinyField(30, 11, 3, FieldStorage::kCell),
        RandomField(30, 11, 6)}) {
    ProbedRenderer& renderer = MakeLearner(field);
    const std::vector<double> values = Gradients(renderer).values;
    const auto reference =
        CreateProbedRenderer({.kind = RendererKind::kReference, .stop_transmittance = 0.0f});
    GiveTask(*reference, field);
    const std::vector<RayBlock> blocks = Blocks(renderer);
    reference->Forward({.blocks = blocks});
    reference->Backward(GradientParts::kColorDensity);
    const std::vector<double> expected = reference->TakeGradients().values;
    ASSERT_EQ(values.size(), expected.size());
    double difference = 0, size = 0;
    for (size_t i = 0; i < values.size(); ++i) {
      difference += (values[i] - expected[i]) * (values[i] - expected[i]);
      size += expected[i] * expected[i];
    }
    EXPECT_LT(std::sqrt(difference / size), 1e-4);
  }
}

// The loss is quadratic in the coefficients, so central differences are exact up to rounding.
TEST_P(HarmonicsTest, GradientsOfCoefficientsAreFiniteDifferences) {
  const RadianceField field = ShinyField(12, 13, 2);
  ProbedRenderer& renderer = MakeLearner(field);
  const std::vector<double> gradients = Gradients(renderer).values;
  const FieldState state = renderer.ReadState();
  const size_t components = size_t(state.layout.Components());
  const std::vector<RayBlock> blocks = Blocks(renderer);
  const auto loss_at = [&](size_t i, float value) {
    std::vector<float> parameters = state.parameters;
    parameters[i] = value;
    renderer.WriteParameters(parameters);
    return renderer.Forward({.blocks = blocks}).loss;
  };
  double largest = 0;
  for (const double gradient : gradients) largest = std::max(largest, std::abs(gradient));
  for (size_t row = 0; row < state.rows(); row += 3) {
    for (size_t k = 0; k < 8; k += 3) {
      const size_t i = row * components + kStandardComponents + 3 * k + k % 3;
      const float before = state.parameters[i];
      const double slope = (loss_at(i, before + 0.5f) - loss_at(i, before - 0.5f)) /
                           (double(before + 0.5f) - double(before - 0.5f));
      EXPECT_NEAR(slope, gradients[i], 1e-3 * largest) << "row " << row << ", function " << k + 1;
    }
  }
}

// Coefficients of 0 leave everything as it is, but for the order of sums.
TEST_P(HarmonicsTest, CoefficientsOfZeroChangeNothing) {
  const RadianceField plain = RandomField(40, 17, 6.0f);
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetState(plain.mesh, StateOf(plain));
  const RenderedImage without = renderer.Render(views_[0], 1);
  const FieldState state = WithHarmonics(StateOf(plain), 3);
  renderer.SetState(plain.mesh, state);
  EXPECT_EQ(renderer.Render(views_[0], 1).color_srgb, without.color_srgb);
  EXPECT_EQ(WithHarmonics(state, 0).parameters, StateOf(plain).parameters);
}

TEST_P(HarmonicsTest, StatesComeBackAsTheyWereSet) {
  FieldLayout layout;
  layout.attributes.push_back(HarmonicsAttribute(2));
  ProbedRenderer& renderer = MakeRenderer();
  const TetMesh mesh = RandomBoxMesh(20, 3);
  ExpectStateComesBack(renderer, mesh, layout);
  ExpectStateComesBack(renderer, mesh, WithExtra(layout));
}

// The few rays of one block pass only some of the tets.
TEST_P(HarmonicsTest, RowsWithoutGradientsKeepTheirCoefficients) {
  const RadianceField field = ShinyField(60, 19, 1);
  ProbedRenderer& renderer = MakeLearner(field);
  const FieldState before = renderer.ReadState();
  const std::vector<RayBlock> blocks = Blocks(renderer);
  const std::vector<RayBlock> few(blocks.begin(), blocks.begin() + 1);
  for (uint32_t step = 1; step <= 3; ++step) renderer.Step({.blocks = few}, {.step = step});
  const FieldState after = renderer.ReadState();
  const size_t components = size_t(after.layout.Components());
  const size_t moments = size_t(after.layout.SecondMoments());
  size_t moved = 0, kept = 0;
  for (size_t i = 0; i < after.parameters.size(); ++i) {
    if (i % components < kStandardComponents) continue;
    const bool is_same = after.parameters[i] == before.parameters[i];
    EXPECT_EQ(is_same, after.second_moment[i / components * moments + kStandardComponents] == 0);
    ++(is_same ? kept : moved);
  }
  EXPECT_GT(moved, 0u);
  EXPECT_GT(kept, moved);
}

std::vector<RowRates> MixedShares(size_t rows) {
  std::vector<RowRates> rates;
  for (size_t row = 0; row < rows; ++row) rates.push_back({.share = 0.25f * float(row % 5)});
  return rates;
}

// Coefficients of a row move without momentum, by one mean square of all their gradients.
TEST_P(HarmonicsTest, CoefficientsMoveByTheirFormula) {
  for (const bool deterministic : {false, true}) {
    for (int degree = 1; degree <= kMostHarmonicsDegree; ++degree) {
      const RadianceField field = ShinyField(25, 29, degree);
      ProbedRenderer& renderer = MakeLearner(field, {.deterministic = deterministic});
      const std::vector<double> gradients = Gradients(renderer).values;
      FieldState want = renderer.ReadState();
      const size_t components = size_t(want.layout.Components());
      const size_t count = components - kStandardComponents;
      // A moment from before, so that it fades.
      for (size_t row = 0; row < want.rows(); row += 2) want.second_moment[row * 5 + 4] = 1e-8f;
      renderer.SetState(field.mesh, want);
      const std::vector<RowRates> rates = MixedShares(want.rows());
      renderer.SetRowRates(rates);
      const AdamUpdate update{.step = 7,
                              .beta2 = 0.9f,
                              .epsilon = 1e-6f,
                              .harmonics_rate = 0.1,
                              .harmonics_decay = 0.5};
      for (size_t row = 0; row < want.rows(); ++row) {
        const double* gradient = &gradients[row * components + kStandardComponents];
        double mean = 0;
        for (size_t i = 0; i < count; ++i) mean += gradient[i] * gradient[i] / double(count);
        if (mean == 0) continue;
        float& moment = want.second_moment[row * 5 + 4];
        moment = float(moment > 0 ? 0.9 * moment + 0.1 * mean : mean);
        for (size_t i = 0; i < count; ++i) {
          float& parameter = want.parameters[row * components + kStandardComponents + i];
          const double share = rates[row].share;
          parameter -= float(share * (0.5 * 0.1 * parameter +
                                      0.1 / (std::sqrt(double(moment)) + 1e-6) * gradient[i]));
        }
      }
      const std::vector<RayBlock> blocks = Blocks(renderer);
      renderer.Step({.blocks = blocks}, update);
      const FieldState after = renderer.ReadState();
      for (size_t row = 0; row < want.rows(); ++row) {
        const double moment = want.second_moment[row * 5 + 4];
        EXPECT_NEAR(after.second_moment[row * 5 + 4], moment, 1e-3 * moment);
        for (size_t i = row * components + kStandardComponents; i < (row + 1) * components; ++i) {
          ASSERT_NEAR(after.parameters[i], want.parameters[i], 1e-4);
        }
      }
    }
  }
}

// Elsewhere values are only alike.
void ExpectSameBitsOnSoftware(const ProbedRenderer& renderer, const std::vector<float>& a,
                              const std::vector<float>& b) {
  if (IsOfSoftware(renderer)) {
    EXPECT_EQ(a, b);
    return;
  }
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-4f * std::abs(b[i]) + 1e-6f);
}

// What one kernel does in a step is what two do apart, with sums between them.
TEST_P(HarmonicsTest, PartsOfAStepMakeItsBits) {
  for (int degree = 1; degree <= kMostHarmonicsDegree; ++degree) {
    const RadianceField field = ShinyField(40, 37, degree);
    ProbedRenderer& whole = MakeLearner(field, {.deterministic = true});
    ProbedRenderer& parts = MakeLearner(field, {.deterministic = true});
    const std::vector<RayBlock> blocks = Blocks(whole);
    for (ProbedRenderer* one : {&whole, &parts}) {
      one->SetRowRates(MixedShares(field.mesh.positions.size()));
    }
    for (uint32_t step = 1; step <= 3; ++step) {
      whole.Step({.blocks = blocks}, {.step = step, .harmonics_decay = 0.5});
      parts.Forward({.blocks = blocks});
      parts.Backward(GradientParts::kColorDensity);
      if (step == 2) parts.AddGradients(parts.TakeGradients());
      parts.Update({.step = step, .harmonics_decay = 0.5});
    }
    const FieldState a = whole.ReadState(), b = parts.ReadState();
    ExpectSameBitsOnSoftware(whole, a.parameters, b.parameters);
    ExpectSameBitsOnSoftware(whole, a.first_moment, b.first_moment);
    ExpectSameBitsOnSoftware(whole, a.second_moment, b.second_moment);
    EXPECT_NE(a.parameters, StateOf(field).parameters);
  }
}

// A step uses sums that were there before it.
TEST_P(HarmonicsTest, AStepUsesGivenGradientsToo) {
  const RadianceField field = ShinyField(20, 31, 2);
  ProbedRenderer& renderer = MakeLearner(field, {.deterministic = true});
  ProbedRenderer& parts = MakeLearner(field, {.deterministic = true});
  const std::vector<RayBlock> blocks = Blocks(renderer);
  for (ProbedRenderer* one : {&renderer, &parts}) {
    one->Forward({.blocks = blocks});
    one->Backward(GradientParts::kColorDensity);
  }
  renderer.Step({.blocks = blocks}, {});
  parts.Forward({.blocks = blocks});
  parts.Backward(GradientParts::kColorDensity);
  parts.Update({});
  EXPECT_EQ(renderer.ReadState().parameters, parts.ReadState().parameters);
}

TEST_P(HarmonicsTest, DeterministicStepsAreTheSameBits) {
  const RadianceField field = ShinyField(40, 23, 3);
  std::vector<std::vector<float>> results;
  for (int run = 0; run < 2; ++run) {
    ProbedRenderer& renderer = MakeRenderer({.deterministic = true});
    GiveTask(renderer, field);
    const std::vector<RayBlock> blocks = Blocks(renderer);
    for (uint32_t step = 1; step <= 3; ++step) renderer.Step({.blocks = blocks}, {.step = step});
    results.push_back(renderer.ReadState().parameters);
    EXPECT_NE(results.back(), StateOf(field).parameters);
  }
  EXPECT_EQ(results[0], results[1]);
}

}  // namespace
}  // namespace tetrec::test
