// Steps of density by its activations.
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec::test {
namespace {

class DensityUpdateTest : public EveryRendererTest {};

INSTANTIATE_TEST_SUITE_P(, DensityUpdateTest, kEveryRenderer, RendererName);

// What a first step of Adam with a large epsilon, and so one that depends on the size of the
// gradient, makes of a field.
struct FirstStep {
  FieldState before, after;
  std::vector<double> gradients;
  // Every second row decays until it is as dense as what is kept; every fifth has a least density.
  std::vector<RowRates> rates;
};

constexpr double kEpsilon = 1e-3, kRate = 0.5, kDecay = 0.2;
constexpr float kLeast = 4.0f;

FirstStep TakeFirstStep(ProbedRenderer& renderer, const RadianceField& field,
                        const Attribute& density) {
  FirstStep step;
  step.before = StateOf(field, density);
  renderer.SetState(field.mesh, step.before);
  const std::vector<RenderView> views = ThreeViews(32, 32);
  const std::vector<TargetImage> targets(views.size(),
                                         {32, 32, std::vector<uint32_t>(32 * 32, 0x7F00FF7Fu)});
  renderer.SetTargets(views, targets);
  const std::vector<RayBlock> blocks = CoveringBlocks(32, 32, 1);
  const TrainingBatch batch{.blocks = blocks, .background_srgb = glm::vec3(0.2f)};
  renderer.Forward(batch);
  renderer.Backward(GradientParts::kColorDensity);
  step.gradients = renderer.TakeGradients().values;
  step.rates.resize(step.before.rows());
  for (size_t row = 0; row < step.rates.size(); row += 2) step.rates[row].kept_density = 1.5f;
  for (size_t row = 0; row < step.rates.size(); row += 5) step.rates[row].least_density = kLeast;
  renderer.SetRowRates(step.rates);
  renderer.Step(batch, {.step = 1,
                        .epsilon = float(kEpsilon),
                        .density_rate = kRate,
                        .max_density = 100,
                        .density_decay = kDecay});
  step.after = renderer.ReadState();
  return step;
}

// The parameter of a row by the slope of its activation, whether it is kept from decay from
// `kept_parameter` on, and whether a bound has raised it.
struct WantedStep {
  double parameter;
  bool is_kept, is_raised;
};

// `least_of_all`: the bound of rows that have none of their own, `least_of_row` that of the others.
WantedStep WantedOf(const FirstStep& step, size_t row, double slope, double kept_parameter,
                    double least_of_all, double least_of_row) {
  const double gradient = slope * step.gradients[row * 4 + kDensityOffset];
  WantedStep want{step.before.parameters[row * 4 + kDensityOffset] -
                      kRate * gradient / (std::abs(gradient) + kEpsilon),
                  false, false};
  const bool is_seen = std::any_of(&step.gradients[row * 4], &step.gradients[row * 4] + 4,
                                   [](double value) { return value != 0; });
  want.is_kept = want.parameter >= kept_parameter;
  if (is_seen && !want.is_kept) want.parameter -= kDecay * kRate;
  const double least = row % 5 == 0 ? least_of_row : least_of_all;
  want.is_raised = want.parameter < least;
  want.parameter = std::max(want.parameter, least);
  return want;
}

TEST_P(DensityUpdateTest, OfSignedDensityFollowsItsSlopeAndStopsAtZero) {
  const Attribute density = SignedDensity(2.0f);
  const RadianceField field = WithAnySign(RandomField(40, 6, 6.0f), 5);
  const FirstStep step = TakeFirstStep(MakeRenderer(), field, density);
  ASSERT_EQ(step.after.layout, step.before.layout);
  size_t moved = 0, stopped = 0, kept = 0, raised = 0;
  for (size_t row = 0; row < step.after.rows(); ++row) {
    const size_t at = row * 4 + kDensityOffset;
    const double slope = std::hypot(double(field.density[row]), 2.0);
    const WantedStep want =
        WantedOf(step, row, slope, std::asinh(double(step.rates[row].kept_density) / 2.0),
                 double(kLeastSignedParameter), std::asinh(double(kLeast) / 2.0));
    kept += want.is_kept;
    raised += want.is_raised && row % 5 == 0;
    if (step.before.parameters[at] > 0 && want.parameter < 0) {
      EXPECT_EQ(step.after.parameters[at], 0.0f) << "it stops at 0";
      EXPECT_EQ(step.after.first_moment[at], 0.0f);
      ++stopped;
      continue;
    }
    EXPECT_NEAR(step.after.parameters[at], want.parameter, 2e-4);
    moved += step.after.parameters[at] != step.before.parameters[at];
  }
  EXPECT_GT(moved, 20u);
  EXPECT_GT(stopped, 0u);
  EXPECT_GT(kept, 0u);
  EXPECT_GT(raised, 0u);
}

TEST_P(DensityUpdateTest, OfPositiveDensityFollowsItsSlope) {
  const RadianceField field = RandomField(40, 6, 6.0f);
  const FirstStep step = TakeFirstStep(MakeRenderer(), field, kDensityAttribute);
  size_t raised = 0;
  for (size_t row = 0; row < step.after.rows(); ++row) {
    const WantedStep want = WantedOf(step, row, double(field.density[row]),
                                     std::log(double(step.rates[row].kept_density)),
                                     double(kLeastLogDensity), std::log(double(kLeast)));
    raised += want.is_raised && row % 5 == 0;
    EXPECT_NEAR(step.after.parameters[row * 4 + kDensityOffset], want.parameter, 2e-4);
  }
  EXPECT_GT(raised, 0u);
}

TEST_P(DensityUpdateTest, OfSoftplusDensityFollowsItsSlope) {
  const double scale = 3;
  RadianceField field = RandomField(40, 6, 6.0f);
  field.density[0] = 0;
  field.density[1] = 1e-9f;  // where 1 + e^parameter is 1 in floats
  const FirstStep step = TakeFirstStep(MakeRenderer(), field, SoftplusDensity(float(scale)));
  ASSERT_EQ(step.after.layout, step.before.layout);
  size_t moved = 0, kept = 0, raised = 0;
  for (size_t row = 0; row < step.after.rows(); ++row) {
    const size_t at = row * 4 + kDensityOffset;
    const double slope = scale * (1 - std::exp(-double(field.density[row]) / scale));
    const double kept_density = step.rates[row].kept_density;
    const double kept_parameter =
        std::isinf(kept_density) ? kept_density : std::log(std::expm1(kept_density / scale));
    const WantedStep want = WantedOf(step, row, slope, kept_parameter, double(kLeastLogDensity),
                                     std::log(std::expm1(double(kLeast) / scale)));
    kept += want.is_kept;
    raised += want.is_raised && row % 5 == 0;
    EXPECT_NEAR(step.after.parameters[at], want.parameter, 2e-4);
    moved += step.after.parameters[at] != step.before.parameters[at];
  }
  EXPECT_GT(moved, 20u);
  EXPECT_GT(kept, 0u);
  EXPECT_GT(raised, 0u);
}

// What is rendered next is the density of the parameters that are read back.
TEST_P(DensityUpdateTest, IsRenderedAsItIsReadBack) {
  for (const Attribute& density : {SignedDensity(2.0f), SoftplusDensity(3.0f)}) {
    const RadianceField field = RandomField(40, 6, 6.0f);
    ProbedRenderer& renderer = MakeRenderer();
    const FirstStep step = TakeFirstStep(renderer, field, density);
    const std::vector<RayBlock> blocks = CoveringBlocks(32, 32, 1);
    const TrainingBatch batch{.blocks = blocks, .background_srgb = glm::vec3(0.2f)};
    const double after_step = renderer.Forward(batch).loss;
    renderer.SetState(field.mesh, StateOf(FieldOf(field.mesh, step.after), density));
    EXPECT_NEAR(renderer.Forward(batch).loss, after_step, 1e-6 * after_step);
  }
}

}  // namespace
}  // namespace tetrec::test
