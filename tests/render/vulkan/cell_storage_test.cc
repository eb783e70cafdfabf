// Density and colour of cells: every renderer against closed forms, the reference and vertices that
// all agree; the reference against finite differences; training.
#include "field/change_storage.h"
#include "render/reference_loss.h"
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetrec::test {
namespace {

RadianceField RandomCells(int points, uint32_t seed, float max_density) {
  return RandomField(points, seed, max_density, FieldStorage::kCell);
}

// The largest difference divided by the largest value.
template <class T, class U>
double RelativeError(const std::vector<T>& values, const std::vector<U>& truth) {
  EXPECT_EQ(values.size(), truth.size());
  double difference = 0, largest = 1e-30;
  for (size_t i = 0; i < truth.size(); ++i) {
    if constexpr (std::is_arithmetic_v<T>) {
      difference = std::max(difference, std::abs(double(values[i]) - double(truth[i])));
      largest = std::max(largest, std::abs(double(truth[i])));
    } else {
      difference = std::max(difference, glm::distance(glm::dvec3(values[i]), glm::dvec3(truth[i])));
      largest = std::max(largest, glm::length(glm::dvec3(truth[i])));
    }
  }
  return difference / largest;
}

const IntegralOptions kIntegrals[] = {
    {IntegralKind::kExact}, {IntegralKind::kMean}, {IntegralKind::kSplit, 3}};

class EveryRenderersCells : public EveryRendererTest {};
INSTANTIATE_TEST_SUITE_P(, EveryRenderersCells, kEveryRenderer, RendererName);

// A ray of length l in one tet: C = c (1 - e^(-sigma l)), T = e^(-sigma l), whatever the form of
// the integral; dC/dc = 1 - T, dC/dsigma = c l T, dT/dsigma = -l T.
TEST_P(EveryRenderersCells, OneTetHasItsClosedForm) {
  RadianceField field;
  field.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  field.mesh.tets = {{0, 1, 2, 3}};
  field.mesh.neighbors = {glm::uvec4(kNoTet)};
  CheckTetMesh(field.mesh);
  field.storage = FieldStorage::kCell;
  field.color_srgb = {{0.9f, 0.5f, 0.2f}};
  // From above, through the face x + y + z = 1 and the face z = 0; and from inside.
  struct Look {
    glm::dvec3 eye;
    double length;
  };
  for (const IntegralOptions& integral : kIntegrals) {
    ProbedRenderer& renderer = MakeRenderer({.integral = integral, .stop_transmittance = 0.0f});
    for (float density : {0.0f, 1e-4f, 0.3f, 2.0f, 4.0f, 40.0f, 1e4f}) {
      field.density = {density};
      renderer.SetField(field);
      for (const Look& look : {Look{{0.2, 0.3, 3.0}, 0.5}, Look{{0.25, 0.25, 0.4}, 0.4}}) {
        SCOPED_TRACE(::testing::Message() << "density " << density << ", " << Name(integral)
                                          << ", length " << look.length);
        const RenderView view = AimAt(look.eye, {look.eye.x, look.eye.y, 0.0});
        const double t = std::exp(-density * look.length);
        const glm::dvec3 color(field.color_srgb[0]);
        const RenderedImage image = renderer.Render(view, 1);
        EXPECT_LT(glm::distance(glm::dvec3(image.color_srgb[0]), (1.0 - t) * color), 2e-6);
        EXPECT_NEAR(image.transmittance[0], t, 2e-6);
        const std::vector<glm::vec4> g = {{0.7f, -0.2f, 0.4f, 0.3f}};
        const FieldGradient gradient = renderer.Backpropagate(view, g);
        ASSERT_EQ(gradient.density.size(), 1u);
        EXPECT_LT(glm::distance(glm::dvec3(gradient.color_srgb[0]), (1.0 - t) * glm::dvec3(g[0])),
                  2e-6);
        const double by_density =
            look.length * t * (glm::dot(glm::dvec3(g[0]), color) - double(g[0].a));
        EXPECT_NEAR(gradient.density[0], by_density, 4e-6);
      }
    }
  }
}

// As for vertices, the error of coordinates in the ray's frame is 2e-7 of their distance.
TEST_P(EveryRenderersCells, PicturesAndGradientsAreThoseOfTheReference) {
  for (const Scene& scene : {Scene{0, 1, 45, 33}, Scene{20, 3, 45, 33}, Scene{300, 4, 37, 27}}) {
    const RadianceField field = RandomCells(scene.points, scene.seed, 10.0f);
    for (const auto& [float_atomics, stop] : {std::pair{true, 1e-3f}, {false, 0.0f}}) {
      ProbedRenderer& renderer =
          MakeRenderer({.device = {.float_atomics = float_atomics}, .stop_transmittance = stop});
      renderer.SetField(field);
      for (const RenderView& view : ThreeViews(scene.width, scene.height)) {
        SCOPED_TRACE(::testing::Message() << scene.points << " points, stop " << stop);
        const RenderedImage image = renderer.Render(view, 1);
        const ReferenceImage truth = RenderReference(field, view, stop);
        for (size_t i = 0; i < truth.color_srgb.size(); ++i) {
          ASSERT_LT(glm::distance(glm::dvec3(image.color_srgb[i]), truth.color_srgb[i]), 2e-5);
          ASSERT_NEAR(image.transmittance[i], std::exp(-truth.optical_depth[i]), 2e-5);
        }
        const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, scene.seed);
        const std::vector<glm::vec4> g_float(g.begin(), g.end());
        const FieldGradient gradient = renderer.Backpropagate(view, g_float);
        const ReferenceGradient expected = BackpropagateReference(field, view, g, stop);
        // Errors are 1e-6 for lengths and 10 times that for weights, for each of a cell's rays.
        EXPECT_LT(RelativeError(gradient.color_srgb, expected.color_srgb), 1e-4);
        EXPECT_LT(RelativeError(gradient.density, expected.density), 1e-4);
      }
      EXPECT_EQ(renderer.counts().lost_rays, 0u);
    }
  }
}

TEST_P(EveryRenderersCells, PositionGradientsAreThoseOfTheReference) {
  for (bool deterministic : {false, true}) {
    ProbedRenderer& renderer =
        MakeRenderer({.stop_transmittance = 0.0f, .deterministic = deterministic});
    const RadianceField field = RandomCells(60, 31, 4.0f);
    renderer.SetField(field);
    for (const RenderView& view : ThreeViews(25, 17)) {
      const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 7);
      const std::vector<glm::vec4> g_float(g.begin(), g.end());
      const FieldGradient gradient =
          renderer.Backpropagate(view, g_float, GradientParts::kColorDensityPosition);
      const ReferenceGradient truth = BackpropagateReference(field, view, g, 0.0);
      EXPECT_LT(RelativeError(gradient.density, truth.density), 3e-5);
      // Faces seen at a flat angle magnify rounding.
      EXPECT_LT(RelativeError(gradient.position, truth.position), 1e-3);
      EXPECT_LT(RelativeError(gradient.absolute_position, truth.absolute_position), 1e-3);
    }
  }
}

// Equal rows interpolate to themselves, up to the rounding of weights.
TEST_P(EveryRenderersCells, AreAsVerticesThatAllAgree) {
  const RadianceField vertices =
      ConstantField(RandomBoxMesh(60, 9), 1.7f, glm::vec3(0.8f, 0.3f, 0.6f));
  const RadianceField cells = WithStorage(vertices, FieldStorage::kCell);
  const RenderView view = ThreeViews(25, 17)[0];
  const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 4);
  const std::vector<glm::vec4> g_float(g.begin(), g.end());
  for (const IntegralOptions& integral : kIntegrals) {
    ProbedRenderer& renderer = MakeRenderer({.integral = integral, .stop_transmittance = 0.0f});
    // One renderer for both: a different storage makes different kernels.
    std::vector<RenderedImage> images;
    std::vector<glm::dvec4> sums;
    for (const RadianceField* field : {&vertices, &cells, &vertices}) {
      renderer.SetField(*field);
      images.push_back(renderer.Render(view, 1));
      const FieldGradient gradient = renderer.Backpropagate(view, g_float);
      glm::dvec4 sum(0.0);
      for (size_t row = 0; row < gradient.density.size(); ++row) {
        sum += glm::dvec4(gradient.color_srgb[row], gradient.density[row]);
      }
      sums.push_back(sum);
    }
    EXPECT_EQ(images[0].color_srgb, images[2].color_srgb);
    for (size_t i = 0; i < images[0].color_srgb.size(); ++i) {
      EXPECT_LT(glm::distance(images[0].color_srgb[i], images[1].color_srgb[i]), 2e-6f);
      EXPECT_NEAR(images[0].transmittance[i], images[1].transmittance[i], 2e-6f);
    }
    // Changing all vertices has the same effect as changing all cells.
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(sums[0][i], sums[1][i], 1e-4);
  }
}

TEST_P(EveryRenderersCells, StepsLowerTheLoss) {
  ProbedRenderer& renderer = MakeRenderer();
  const RadianceField truth = RandomCells(20, 51, 6.0f);
  const std::vector<RenderView> views = {ThreeViews(20, 14)[0]};
  renderer.SetField(truth);
  const RenderedImage image = renderer.Render(views[0], 1);
  TargetImage target{20, 14, {}};
  for (size_t i = 0; i < image.color_srgb.size(); ++i) {
    uint32_t rgba = uint32_t(std::lround(255 * (1 - image.transmittance[i]))) << 24;
    for (int c = 0; c < 3; ++c)
      rgba |= uint32_t(std::lround(255 * image.color_srgb[i][c])) << 8 * c;
    target.rgba8.push_back(rgba);
  }
  renderer.SetTargets(views, std::vector<TargetImage>{target});
  RadianceField start = truth;
  std::fill(start.density.begin(), start.density.end(), 0.2f);
  std::fill(start.color_srgb.begin(), start.color_srgb.end(), glm::vec3(0.5f));
  renderer.SetField(start);
  const std::vector<double> losses = LearnPictures(renderer, views, 150);
  EXPECT_LT(losses.back(), 0.02 * losses[2]);
}

TEST(CellReference, GradientsAgreeWithFiniteDifferences) {
  for (const IntegralOptions& integral : kIntegrals) {
    RadianceField field = RandomCells(4, 21, 3.0f);
    const RenderView view = ThreeViews(9, 7)[0];
    const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 6);
    const ReferenceGradient gradient = BackpropagateReference(field, view, g, 0.0, integral);
    ASSERT_EQ(gradient.density.size(), field.mesh.tets.size());
    ASSERT_EQ(gradient.position.size(), field.mesh.positions.size());
    for (size_t t = 0; t < field.density.size(); ++t) {
      const float density_before = field.density[t];
      field.density[t] = std::max(field.density[t], 0.01f);  // room for a step down
      const ReferenceGradient here = BackpropagateReference(field, view, g, 0.0, integral);
      EXPECT_NEAR(CentralDifference(field, field.density[t], 1e-3f, view, g, integral),
                  here.density[t], 1e-6);
      EXPECT_NEAR(CentralDifference(field, field.color_srgb[t].g, 1e-2f, view, g, integral),
                  here.color_srgb[t].g, 1e-9);
      field.density[t] = density_before;
    }
    double largest = 0;
    for (const glm::dvec3& p : gradient.position) largest = std::max(largest, glm::length(p));
    // The first 8 are the box's corners, in any order; a few rays within a step of an edge have an
    // error of a step's share of their gradient.
    for (size_t v = 0; v < gradient.position.size(); ++v) {
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(
            CentralDifference(field, field.mesh.positions[v][axis], 1e-5f, view, g, integral),
            gradient.position[v][axis], 2e-4 * largest)
            << "vertex " << v << ", axis " << axis << ", " << Name(integral);
      }
    }
  }
}

using CellMarch = RendererTest;

TEST_F(CellMarch, ScoresShareOutTheSquaredResidualOfEveryRay) {
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  const RadianceField field = RandomCells(40, 60, 3.0f);
  const std::vector<RenderView> views = ThreeViews(20, 14);
  const std::vector<TargetImage> black(views.size(),
                                       {20, 14, std::vector<uint32_t>(20 * 14, 0xFF000000u)});
  renderer.SetTargets(views, black);
  renderer.SetField(field);
  double expected = 0, residuals = 0;
  for (const RenderView& view : views) {
    const ReferenceImage image = RenderReference(field, view, 0.0);
    for (size_t i = 0; i < image.color_srgb.size(); ++i) {
      const double square = glm::dot(image.color_srgb[i], image.color_srgb[i]);
      residuals += square;
      expected += square * -std::expm1(-image.optical_depth[i]);
    }
  }
  renderer.ClearScores();
  const std::vector<RayBlock> blocks = BlocksOf(views);
  renderer.AddScores({.blocks = blocks}, ScoreKind::kSquaredResidual);
  const std::vector<float> scores = renderer.ReadScores().errors;
  const double sum = std::accumulate(scores.begin(), scores.end(), 0.0);
  EXPECT_LE(sum, expected * (1.0 + 1e-4));
  // Shares below 1e-3 are omitted; a ray meets at most 20 tets.
  EXPECT_GE(sum, expected - 20 * 1e-3 * residuals);
}

TEST_F(CellMarch, StateComesBackAsItWasSet) {
  ExpectStateComesBack(MakeRenderer(), RandomBoxMesh(40, 56), {.storage = FieldStorage::kCell});
}

// Adam's first step moves every row that was seen by its rate.
TEST_F(CellMarch, FirstStepMovesEverySeenCellByItsRate) {
  for (bool deterministic : {false, true}) {
    ProbedRenderer& renderer =
        MakeRenderer({.stop_transmittance = 0.0f, .deterministic = deterministic});
    const RadianceField field = RandomCells(20, 54, 3.0f);
    const std::vector<RenderView> views = {ThreeViews(20, 14)[0]};
    renderer.SetTargets(
        views, std::vector<TargetImage>{{20, 14, std::vector<uint32_t>(20 * 14, 0xFF000000u)}});
    renderer.SetField(field);
    const ReferenceImage image = RenderReference(field, views[0], 0.0);
    std::vector<glm::dvec4> g;
    for (const glm::dvec3& color : image.color_srgb) g.emplace_back(2.0 * color, 0.0);
    const ReferenceGradient gradient = BackpropagateReference(field, views[0], g, 0.0);
    const std::vector<RayBlock> blocks = AllBlocks(views[0].camera);
    renderer.Step({.blocks = blocks}, {});
    const std::vector<glm::vec4> parameters = StandardRows(renderer.ReadState().parameters);
    const AdamUpdate adam;
    int checked = 0;
    for (size_t t = 0; t < field.density.size(); ++t) {
      if (std::abs(field.density[t] * gradient.density[t]) < 1e-3) continue;
      EXPECT_NEAR(
          parameters[t].a,
          std::log(field.density[t]) - std::copysign(adam.density_rate, gradient.density[t]), 1e-4);
      ++checked;
    }
    EXPECT_GT(checked, 20);
  }
}

}  // namespace
}  // namespace tetrec::test
