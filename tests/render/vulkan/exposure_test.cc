// Exposures of training views: gradients through them against differences of the loss, their sums
// against the exposures that made the targets.
#include "render/exposure.h"

#include "render/scenes.h"
#include "render/targets.h"
#include "shared/exposure.glsl.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace tetrec::test {
namespace {

constexpr int kExposureWidth = 20, kExposureHeight = 14;
constexpr glm::vec3 kExposureBackground(0.1f, 0.7f, 0.4f);

std::vector<RenderView> TwoViews() {
  return {LookAt({1.7, -1.1, -1.0}, {0.0, 0.35, 0.65}, kExposureWidth, kExposureHeight),
          LookAt({0.1, 0.4, 0.5}, {0.0, 0.35, 0.65}, kExposureWidth, kExposureHeight)};
}

std::vector<ViewExposure> TwoExposures() {
  return {{{0.7, 0.95, 0.8}, {0.05, -0.02, 0.01}}, {{0.9, 0.6, 0.75}, {-0.04, 0.03, 0.02}}};
}

// What the views show of the field under these exposures by samples x samples rays per pixel,
// rounded to 8 bits.
std::vector<TargetImage> ExposedTargets(const RadianceField& field,
                                        const std::vector<ViewExposure>& exposures,
                                        int samples = 1) {
  const auto renderer =
      CreateProbedRenderer({.kind = RendererKind::kReference, .stop_transmittance = 0.0f});
  renderer->SetField(field);
  std::vector<TargetImage> targets;
  const std::vector<RenderView> views = TwoViews();
  for (size_t v = 0; v < views.size(); ++v) {
    const RenderedImage image = renderer->Render(views[v], samples);
    targets.push_back({kExposureWidth, kExposureHeight, {}});
    for (size_t i = 0; i < image.color_srgb.size(); ++i) {
      const double transmittance = double(image.transmittance[i]);
      uint32_t rgba = uint32_t(std::lround(255 * (1 - transmittance))) << 24;
      for (int c = 0; c < 3; ++c) {
        const double shown = ExposedColor(double(image.color_srgb[i][c]), transmittance,
                                          exposures[v].gain[c], exposures[v].offset[c]);
        rgba |= uint32_t(std::lround(255 * std::max(0.0, shown))) << (8 * c);
      }
      targets.back().rgba8.push_back(rgba);
    }
  }
  return targets;
}

// The blocks of one whole view with samples x samples rays per pixel.
std::vector<RayBlock> BlocksOfView(uint32_t view, int samples) {
  Camera camera = TwoViews()[view].camera;
  camera.width *= samples;
  camera.height *= samples;
  return AllBlocks(camera, view);
}

// Blocks of one whole view, which are one tile.
TrainingBatch BatchOf(const std::vector<RayBlock>& blocks, float dssim_weight) {
  return {.blocks = blocks,
          .dssim_weight = dssim_weight,
          .tiles = {kExposureWidth / kRayBlockWidth, kExposureHeight / kRayBlockHeight},
          .background_srgb = kExposureBackground};
}

class ExposureTest : public EveryRendererTest {};

INSTANTIATE_TEST_SUITE_P(, ExposureTest, kEveryRenderer, RendererName);

// The loss in double precision.
double LossOfField(const RadianceField& field, const TrainingBatch& batch) {
  const auto renderer =
      CreateProbedRenderer({.kind = RendererKind::kReference, .stop_transmittance = 0.0f});
  renderer->SetTargets(TwoViews(), RandomTargets(2, kExposureWidth, kExposureHeight));
  renderer->SetExposures(TwoExposures());
  renderer->SetField(field);
  return renderer->Forward(batch).loss;
}

double Slope(RadianceField& field, float& value, float step, const TrainingBatch& batch) {
  const float before = value, above = before + step, below = before - step;
  value = above;
  const double loss_above = LossOfField(field, batch);
  value = below;
  const double loss_below = LossOfField(field, batch);
  value = before;
  return (loss_above - loss_below) / (double(above) - double(below));
}

TEST_P(ExposureTest, GradientsAgreeWithDifferencesOfTheLoss) {
  struct Kind {
    float dssim_weight;
    int samples;
    float alpha_weight = 0;
  };
  for (const auto& [dssim_weight, samples, alpha_weight] :
       {Kind{0.0f, 1}, Kind{0.3f, 1}, Kind{0.0f, 2}, Kind{0.0f, 2, 1.5f}, Kind{0.3f, 1, 1.5f}}) {
    RadianceField field = RandomField(40, 55, 3.0f);
    const std::vector<RayBlock> blocks = BlocksOfView(1, samples);
    TrainingBatch batch = BatchOf(blocks, dssim_weight);
    batch.samples = samples;
    batch.alpha_weight = alpha_weight;
    ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
    renderer.SetTargets(TwoViews(), RandomTargets(2, kExposureWidth, kExposureHeight));
    renderer.SetExposures(TwoExposures());
    renderer.SetField(field);
    EXPECT_NEAR(renderer.Forward(batch).loss, LossOfField(field, batch), 1e-5);
    renderer.Backward(GradientParts::kColorDensity);
    const GradientSums sums = renderer.TakeGradients();
    double largest[2] = {0, 0};
    for (size_t i = 0; i < sums.values.size(); ++i) {
      double& of_kind = largest[i % 4 == 3];
      of_kind = std::max(of_kind, std::abs(sums.values[i]));
    }
    for (size_t row = 0; row < field.density.size(); row += 5) {
      const int c = int(row % 3);
      // The loss is quadratic in colour; in density, 1e-3 leaves 1e-6 of the third derivative.
      const double tolerance = dssim_weight > 0 ? 3e-3 : 1e-3;
      EXPECT_NEAR(sums.values[4 * row + size_t(c)],
                  Slope(field, field.color_srgb[row][c], 1e-3f, batch), tolerance * largest[0])
          << "vertex " << row;
      if (field.density[row] < 0.01f) continue;  // less than nothing is refused
      EXPECT_NEAR(sums.values[4 * row + 3], Slope(field, field.density[row], 1e-3f, batch),
                  tolerance * largest[1])
          << "vertex " << row;
    }
  }
}

// The mean of a pixel's rays is compared, not each ray.
TEST_P(ExposureTest, LossOfFineRaysIsThatOfTheRenderedPicture) {
  const RadianceField field = RandomField(40, 55, 3.0f);
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  const std::vector<TargetImage> targets = RandomTargets(2, kExposureWidth, kExposureHeight);
  renderer.SetTargets(TwoViews(), targets);
  renderer.SetField(field);
  const std::vector<RayBlock> blocks = BlocksOfView(0, 2);
  TrainingBatch batch = BatchOf(blocks, 0);
  batch.samples = 2;
  batch.alpha_weight = 0.75f;
  const StepResult result = renderer.Forward(batch);
  const RenderedImage image = renderer.Render(TwoViews()[0], 2);
  double squares = 0, squares_of_opacity = 0;
  for (size_t i = 0; i < image.color_srgb.size(); ++i) {
    const uint32_t rgba = targets[0].rgba8[i];
    if (rgba == kNotJudgedTarget) continue;
    const double alpha = double(rgba >> 24) / 255, opacity = 1 - double(image.transmittance[i]);
    squares_of_opacity += (opacity - alpha) * (opacity - alpha);
    for (int c = 0; c < 3; ++c) {
      const double wanted =
          double(rgba >> (8 * c) & 255) / 255 + (1 - alpha) * double(kExposureBackground[c]);
      const double shown = double(image.color_srgb[i][c]) +
                           double(image.transmittance[i]) * double(kExposureBackground[c]);
      squares += (shown - wanted) * (shown - wanted);
    }
  }
  const double pixels = double(image.color_srgb.size());
  EXPECT_NEAR(result.squared_error, squares / (3 * pixels), 1e-6);
  EXPECT_NEAR(result.loss, (squares + 0.75 * squares_of_opacity) / (3 * pixels), 1e-6);
}

TEST_P(ExposureTest, SumsLeadBackToTheExposuresThatMadeTheTargets) {
  const RadianceField field = RandomField(40, 55, 3.0f);
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  for (const int samples : {1, 2}) {
    renderer.SetTargets(TwoViews(), ExposedTargets(field, TwoExposures(), samples));
    renderer.SetField(field);
    std::vector<ExposureSums> sums(2);
    for (uint32_t view = 0; view < 2; ++view) {
      const std::vector<RayBlock> blocks = BlocksOfView(view, samples);
      TrainingBatch batch = BatchOf(blocks, 0);
      batch.samples = samples;
      batch.sums_exposures = true;
      renderer.Forward(batch);
    }
    renderer.AddExposureSums(sums);
    for (size_t view = 0; view < 2; ++view) {
      for (int c = 0; c < 3; ++c) {
        const GainOffset fit = FitGainOffset(sums[view][size_t(c)]).value();
        // Rounding to 8 bits is up to 2e-3 in a pixel, of which hundreds count. Means of rays vary
        // less than rays do, so a fit to them is less certain.
        EXPECT_NEAR(fit.gain, TwoExposures()[view].gain[c], 4e-3 * samples);
        EXPECT_NEAR(fit.offset, TwoExposures()[view].offset[c], 2e-3 * samples);
      }
    }
  }
}

TEST_P(ExposureTest, UnderTheirOwnExposuresTargetsLeaveNoLoss) {
  const RadianceField field = RandomField(40, 55, 3.0f);
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  renderer.SetTargets(TwoViews(), ExposedTargets(field, TwoExposures()));
  renderer.SetField(field);
  const std::vector<RayBlock> blocks = AllBlocks(TwoViews()[0].camera, 0);
  const double neutral = renderer.Forward(BatchOf(blocks, 0)).squared_error;
  renderer.SetExposures(TwoExposures());
  const double exposed = renderer.Forward(BatchOf(blocks, 0)).squared_error;
  EXPECT_LT(exposed, 1.0 / (255 * 255));
  EXPECT_GT(neutral, 10 * exposed);
}

TEST_P(ExposureTest, SumsAreTheSameBitsHoweverOftenTheyAreTaken) {
  const RadianceField field = RandomField(40, 55, 3.0f);
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetTargets(TwoViews(), RandomTargets(2, kExposureWidth, kExposureHeight));
  renderer.SetState(field.mesh, StateOf(field));
  std::vector<ExposureSums> at_once(2), step_by_step(2);
  const auto step = [&](uint32_t i) {
    const std::vector<RayBlock> blocks = AllBlocks(TwoViews()[i % 2].camera, i % 2);
    TrainingBatch batch = BatchOf(blocks, 0);
    batch.seed = i;
    batch.jitter_px = 0.5f;
    batch.sums_exposures = i != 3;
    renderer.Step(batch, kStandingUpdate);
  };
  for (uint32_t i = 0; i < 6; ++i) step(i);
  renderer.AddExposureSums(at_once);
  for (uint32_t i = 0; i < 6; ++i) {
    step(i);
    if (i != 2) renderer.AddExposureSums(step_by_step);
  }
  EXPECT_GT(at_once[0][0].ww, 0);
  EXPECT_EQ(step_by_step, at_once);
}

TEST_P(ExposureTest, ScoresAreErrorsOfWhatTheViewShows) {
  const RadianceField field = RandomField(40, 55, 3.0f);
  const std::vector<RayBlock> blocks = AllBlocks(TwoViews()[0].camera, 0);
  const auto scores_of = [&](ProbedRenderer& renderer) {
    renderer.SetTargets(TwoViews(), RandomTargets(2, kExposureWidth, kExposureHeight));
    renderer.SetField(field);
    renderer.SetExposures(TwoExposures());
    renderer.ClearScores();
    renderer.AddScores(BatchOf(blocks, 0), ScoreKind::kSquaredResidual);
    return renderer.ReadScores().errors;
  };
  const std::vector<float> scores = scores_of(MakeRenderer());
  // The score of a ray's tets sums to its squared residual times its opacity.
  const auto reference = CreateProbedRenderer({.kind = RendererKind::kReference});
  const std::vector<float> expected = scores_of(*reference);
  const float largest = *std::max_element(expected.begin(), expected.end());
  EXPECT_GT(largest, 0.1f);
  for (size_t tet = 0; tet < scores.size(); ++tet) {
    EXPECT_NEAR(scores[tet], expected[tet], 1e-3f * largest) << "tet " << tet;
  }
}

}  // namespace
}  // namespace tetrec::test
