// The reference renderer trains as the march does, with the same bits for any number of threads.
#include "render/reference/reference_renderer.h"

#include "render/reference/render_picture.h"
#include "render/reference_loss.h"
#include "render/scenes.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace tetrec::test {
namespace {

constexpr int kWidth = 22, kHeight = 15;

RendererOptions Reference(Precision precision) {
  return {.kind = RendererKind::kReference, .precision = precision};
}

// Random images, with alpha.
std::vector<TargetImage> RandomTargets(const std::vector<RenderView>& views, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<TargetImage> targets;
  for (const RenderView& view : views) {
    TargetImage target{view.camera.width, view.camera.height, {}};
    for (int i = 0; i < target.width * target.height; ++i) {
      target.rgba8.push_back(uint32_t(random()) & 0x7F7F7F7Fu);
    }
    targets.push_back(target);
  }
  return targets;
}

struct Lesson {
  RadianceField field = RandomField(60, 91, 5.0f);
  std::vector<RenderView> views = ThreeViews(kWidth, kHeight);
  std::vector<TargetImage> targets = RandomTargets(views, 92);
};

struct Learnt {
  FieldState state;
  std::vector<double> losses;
  TetScores scores;
};

// Every second row keeps its density above the middle of their range, and every fifth has a bound
// below which its density does not fall.
std::vector<RowRates> MixedRates(size_t rows) {
  std::vector<RowRates> rates(rows);
  for (size_t row = 0; row < rows; row += 2) rates[row].kept_density = 2.5f;
  for (size_t row = 0; row < rows; row += 5) rates[row].least_density = 1.0f;
  return rates;
}

// Takes steps over blocks of all views with jitter, then gathers scores.
Learnt Learn(ProbedRenderer& renderer, const Lesson& lesson, LossKind loss) {
  renderer.SetField(lesson.field);
  renderer.SetTargets(lesson.views, lesson.targets);
  renderer.SetRowRates(MixedRates(lesson.field.mesh.positions.size()));
  std::vector<RayBlock> blocks;
  for (uint32_t v = 0; v < lesson.views.size(); ++v) {
    const auto all = AllBlocks(lesson.views[v].camera, v);
    blocks.insert(blocks.end(), all.begin(), all.end());
  }
  std::shuffle(blocks.begin(), blocks.end(), std::mt19937(93));
  Learnt learnt;
  TrainingBatch step{.blocks = blocks, .loss = loss, .jitter_px = 0.8f};
  for (uint32_t i = 1; i <= 6; ++i) {
    step.background_srgb = glm::vec3(0.1f * float(i), 0.5f, 0.9f);
    step.seed = 94 + i;
    // Adam divides gradients by their size: a larger epsilon keeps rounding from deciding where
    // vertices go that hardly any ray sees.
    learnt.losses.push_back(
        renderer.Step(step, {.step = i, .epsilon = 1e-3f, .density_decay = 0.1}).loss);
  }
  learnt.state = renderer.ReadState();
  renderer.ClearScores();
  renderer.AddScores(step, ScoreKind::kSquaredResidual);
  learnt.scores = renderer.ReadScores();
  return learnt;
}

double LargestDifference(const std::vector<float>& a, const std::vector<float>& b) {
  double largest = 0;
  for (size_t i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(double(a[i]) - b[i]));
  }
  return largest;
}

TEST_F(RendererTest, ReferenceLearnsWhatTheMarchLearns) {
  const Lesson lesson;
  for (LossKind loss : {LossKind::kL2, LossKind::kL1}) {
    const Learnt march = Learn(MakeRenderer(), lesson, loss);
    for (Precision precision : {Precision::kDouble, Precision::kFloat}) {
      SCOPED_TRACE(::testing::Message() << (loss == LossKind::kL2 ? "L2" : "L1") << ", "
                                        << (precision == Precision::kFloat ? "float" : "double"));
      const Learnt reference = Learn(*CreateReferenceRenderer(Reference(precision)), lesson, loss);
      ASSERT_EQ(reference.losses.size(), march.losses.size());
      for (size_t i = 0; i < march.losses.size(); ++i) {
        EXPECT_NEAR(reference.losses[i], march.losses[i], 1e-5);
      }
      // Six steps of up to 0.2; gradients agree to 3e-5 of the largest. With L1 a residual near 0
      // may have either sign: one of 1,188 rays moves a vertex by a thousandth of a step.
      const double tolerance = loss == LossKind::kL2 ? 2e-4 : 2e-3;
      EXPECT_LT(LargestDifference(reference.state.parameters, march.state.parameters), tolerance);
      const double most = *std::max_element(march.scores.errors.begin(), march.scores.errors.end());
      for (size_t t = 0; t < march.scores.errors.size(); ++t) {
        // Rounding decides if a share of a thousandth counts.
        EXPECT_NEAR(reference.scores.errors[t], march.scores.errors[t], 1e-3 * most + 5e-3)
            << "tet " << t;
        // And if a share of a hundredth is seen.
        EXPECT_NEAR(reference.scores.light[t], march.scores.light[t], 2.5e-2) << "tet " << t;
      }
    }
  }
}

// Confines the process to one core until the end of the scope.
class OneCore {
 public:
  OneCore() {
    sched_getaffinity(0, sizeof(before_), &before_);
    cpu_set_t one;
    CPU_ZERO(&one);
    for (int core = 0; core < CPU_SETSIZE; ++core) {
      if (CPU_ISSET(core, &before_) && CPU_COUNT(&one) == 0) CPU_SET(core, &one);
    }
    sched_setaffinity(0, sizeof(one), &one);
  }
  ~OneCore() { sched_setaffinity(0, sizeof(before_), &before_); }

 private:
  cpu_set_t before_;
};

TEST(ReferenceRenderer, LearnsTheSameBitsOnOneCoreAsOnAll) {
  const Lesson lesson;
  for (Precision precision : {Precision::kDouble, Precision::kFloat}) {
    const auto renderer = CreateReferenceRenderer(Reference(precision));
    const Learnt all = Learn(*renderer, lesson, LossKind::kL2);
    const OneCore scope;
    const Learnt one = Learn(*CreateReferenceRenderer(Reference(precision)), lesson, LossKind::kL2);
    EXPECT_EQ(LargestDifference(one.state.parameters, all.state.parameters), 0.0);
    EXPECT_EQ(LargestDifference(one.state.second_moment, all.state.second_moment), 0.0);
    EXPECT_EQ(one.losses, all.losses);
    EXPECT_EQ(one.scores.errors, all.scores.errors);
    EXPECT_EQ(one.scores.light, all.scores.light);
  }
}

TEST(ReferenceRenderer, InFloatHasThePictureAndGradientsOfDoubleUpToItsRounding) {
  const auto renderer = CreateReferenceRenderer(Reference(Precision::kFloat));
  for (int points : {0, 20, 300}) {
    const RadianceField field = RandomField(points, 95, 10.0f);
    renderer->SetField(field);
    for (const RenderView& view : ThreeViews(kWidth, kHeight)) {
      const RenderedImage image = renderer->Render(view, 1);
      const ReferenceImage truth = RenderReference(field, view, 1e-3f);
      for (size_t i = 0; i < truth.color_srgb.size(); ++i) {
        // World coordinates of 3 round to 2e-7, rays cut faces at any angle, densities are up to
        // 10.
        ASSERT_LT(glm::distance(glm::dvec3(image.color_srgb[i]), truth.color_srgb[i]), 1e-4)
            << points << " points, pixel " << i;
      }
      const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 96);
      const FieldGradient gradient =
          renderer->Backpropagate(view, std::vector<glm::vec4>(g.begin(), g.end()));
      const ReferenceGradient exact = BackpropagateReference(field, view, g, 1e-3f);
      double error = 0, norm = 0;
      for (size_t v = 0; v < exact.density.size(); ++v) {
        error += std::pow(gradient.density[v] - exact.density[v], 2);
        norm += std::pow(exact.density[v], 2);
      }
      EXPECT_LT(std::sqrt(error / norm), 1e-4) << points << " points";
    }
  }
}

TEST(ReferenceRenderer, LowersTheLoss) {
  const Lesson lesson;
  const auto renderer = CreateReferenceRenderer(Reference(Precision::kDouble));
  renderer->SetField(lesson.field);
  const TargetImage orange{kWidth, kHeight, std::vector<uint32_t>(kWidth * kHeight, 0xFF1070E0u)};
  renderer->SetTargets(lesson.views, std::vector(lesson.views.size(), orange));
  const auto blocks = AllBlocks(lesson.views[1].camera, 1);  // from inside: every ray hits
  std::vector<double> losses;
  for (uint32_t i = 1; i <= 30; ++i) {
    losses.push_back(renderer->Step({.blocks = blocks, .seed = i}, {.step = i}).loss);
  }
  EXPECT_EQ(losses[0], 0.0);  // results come late
  EXPECT_LT(losses.back(), 0.5 * losses[2]);
}

}  // namespace
}  // namespace tetrec::test
