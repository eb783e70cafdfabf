// Per-pixel lists against the march and the reference renderer; tiles, sorts, memory.
#include "mesh/delaunay.h"
#include "render/reference/render_picture.h"
#include "render/scenes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace tetrec::test {
namespace {

// The error of both renderers is 1e-6 of a length, at densities of up to 10
// (march_reference_test.cc).
constexpr float kTolerance = 2e-5f;

// Outside at a corner, inside, outside in front of one face, far away; odd sizes cut blocks off.
std::vector<RenderView> FourViews(int width, int height) {
  return {LookAt({1.7, -1.1, -1.0}, {0.0, 0.3, 0.6}, width, height),
          LookAt({0.1, 0.4, 0.5}, {0.3, 0.6, 0.9}, width, height, 0.5),
          LookAt({0.1, 0.4, 2.5}, {0.0, 0.4, 0.9}, width, height),
          LookAt({17.0, -11.0, -10.0}, {0.0, 0.3, 0.6}, width, height, 10.0)};
}

std::vector<glm::uvec4> Bits(const std::vector<glm::vec4>& rays) {
  std::vector<glm::uvec4> bits;
  for (const glm::vec4& ray : rays) bits.push_back(std::bit_cast<glm::uvec4>(ray));
  return bits;
}

std::vector<glm::vec4> RandomGradient(const Camera& camera, uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::vector<glm::vec4> gradient(size_t(camera.width) * camera.height);
  for (glm::vec4& g : gradient) {
    for (int i = 0; i < 4; ++i) g[i] = normal(random);
  }
  return gradient;
}

// The largest difference divided by the largest value.
double RelativeError(const FieldGradient& a, const FieldGradient& b) {
  double difference = 0, largest = 0;
  for (size_t v = 0; v < a.density.size(); ++v) {
    const glm::dvec4 x(a.color_srgb[v], a.density[v]), y(b.color_srgb[v], b.density[v]);
    difference = std::max(difference, glm::distance(x, y));
    largest = std::max(largest, glm::length(y));
  }
  return difference / largest;
}

RadianceField OneTetField() {
  RadianceField field;
  field.mesh =
      BuildDelaunay(
          std::vector<glm::vec3>{
              {-0.5f, 0.0f, 0.3f}, {0.5f, 0.1f, 0.4f}, {0.1f, 0.9f, 0.5f}, {0.0f, 0.3f, 1.0f}})
          .mesh;
  field.density = {1.0f, 5.0f, 0.1f, 8.0f};
  field.color_srgb = {glm::vec3(1, 0, 0), glm::vec3(0, 1, 0), glm::vec3(0, 0, 1), glm::vec3(1)};
  return field;
}

TEST_F(RendererTest, ListsAndMarchGiveTheSameRaysAndGradients) {
  for (int points : {-1, 0, 1, 20, 320}) {
    for (float stop : {0.0f, 1e-3f}) {
      const RadianceField field =
          points < 0 ? OneTetField() : RandomField(points, uint32_t(70 + points), 10.0f);
      ProbedRenderer& lists =
          MakeRenderer({.kind = RendererKind::kPpll, .stop_transmittance = stop});
      ProbedRenderer& march = MakeRenderer({.stop_transmittance = stop});
      lists.SetField(field);
      march.SetField(field);
      for (const RenderView& view : FourViews(45, 33)) {
        // The error of directions is 6e-8, which moves rays in proportion to the distance.
        const float tolerance = kTolerance * float(std::max(1.0, glm::length(Eye(view)) / 3.0));
        const auto blocks = AllBlocks(view.camera);
        const auto a = lists.MarchBlocks(view, blocks), b = march.MarchBlocks(view, blocks);
        for (size_t r = 0; r < a.size(); ++r) {
          ASSERT_LT(glm::distance(glm::vec3(a[r]), glm::vec3(b[r])), tolerance)
              << points << " points, ray " << r;
          ASSERT_NEAR(std::exp(-a[r].a), std::exp(-b[r].a), tolerance)
              << points << " points, ray " << r;
        }
        const auto g = RandomGradient(view.camera, 7);
        EXPECT_LT(RelativeError(lists.Backpropagate(view, g), march.Backpropagate(view, g)), 5e-5)
            << points << " points";
      }
      EXPECT_EQ(lists.counts().lost_rays, 0u);
    }
  }
}

TEST_F(RendererTest, TilesGiveTheSameBitsAsOnePass) {
  const RadianceField field = RandomField(300, 82, 10.0f);
  ProbedRenderer& whole = MakeRenderer({.kind = RendererKind::kPpll});
  whole.SetField(field);
  // With lists of 40 fragments, tiles are a few rows, parts of rows or a few pixels.
  for (uint64_t memory : {40'000u, 8'000u, 1'000u}) {
    ProbedRenderer& tiled = MakeRenderer({.kind = RendererKind::kPpll, .fragment_memory = memory});
    tiled.SetField(field);
    for (const RenderView& view : FourViews(37, 17)) {
      const auto blocks = AllBlocks(view.camera);
      EXPECT_EQ(Bits(tiled.MarchBlocks(view, blocks)), Bits(whole.MarchBlocks(view, blocks)))
          << memory << " bytes";
      const auto g = RandomGradient(view.camera, 8);
      // The same terms, added in another order.
      EXPECT_LT(RelativeError(tiled.Backpropagate(view, g), whole.Backpropagate(view, g)), 1e-5)
          << memory << " bytes";
    }
    EXPECT_EQ(tiled.counts().lost_rays, 0u);
  }
}

// A pole of thin slices: rays along it pass more than a thousand faces.
RadianceField PoleField() {
  std::vector<glm::vec3> points;
  std::mt19937 random(83);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 8; ++i) points.push_back(BoxCorner(i));
  for (int i = 0; i < 3000; ++i)
    points.emplace_back(unit(random), unit(random), 1.0f + 600.0f * unit(random));
  RadianceField field = ConstantField(BuildDelaunay(points).mesh, 0.01f, glm::vec3(0.5f));
  for (float& density : field.density) density = 0.02f * unit(random);
  for (glm::vec3& color : field.color_srgb) color.g = unit(random);
  return field;
}

TEST_F(RendererTest, SortsOfListsOfAnyLengthGiveTheSameBits) {
  const RadianceField field = PoleField();
  const RenderView views[] = {LookAt({0.45, 0.5, -3.0}, {0.55, 0.5, 600.0}, 8, 4, 100.0),
                              LookAt({0.5, 0.45, 50.0}, {0.4, 0.5, 600.0}, 8, 4, 100.0),
                              LookAt({30.0, 0.4, 200.0}, {0.5, 0.5, 300.0}, 16, 8)};
  std::vector<std::vector<glm::uvec4>> rays;
  for (FragmentSort sort : {FragmentSort::kAuto, FragmentSort::kShell, FragmentSort::kHeap}) {
    ProbedRenderer& renderer = MakeRenderer(
        {.kind = RendererKind::kPpll, .stop_transmittance = 0.0f, .fragment_sort = sort});
    renderer.SetField(field);
    rays.emplace_back();
    for (const RenderView& view : views) {
      const auto bits = Bits(renderer.MarchBlocks(view, AllBlocks(view.camera)));
      rays.back().insert(rays.back().end(), bits.begin(), bits.end());
    }
  }
  EXPECT_EQ(rays[1], rays[0]);
  EXPECT_EQ(rays[2], rays[0]);
  // The lists exceed 1024 fragments, so both kernels of kAuto had work.
  ProbedRenderer& small = MakeRenderer({.kind = RendererKind::kPpll, .fragment_memory = 8 * 1024});
  small.SetField(field);
  EXPECT_THROW(small.MarchBlocks(views[0], AllBlocks(views[0].camera)), EnvironmentError);
  ProbedRenderer& march = MakeRenderer({.stop_transmittance = 0.0f});
  march.SetField(field);
  const auto truth = march.MarchBlocks(views[0], AllBlocks(views[0].camera));
  for (size_t r = 0; r < truth.size(); ++r) {
    // Depths add up over 1e3 segments along a distance of 600.
    EXPECT_NEAR(std::bit_cast<glm::vec4>(rays[0][r]).a, truth[r].a, 1e-4f * truth[r].a);
  }
}

TEST_F(RendererTest, ListThatDoesNotFitIsAnErrorThatNamesItsMemory) {
  ProbedRenderer& renderer = MakeRenderer({.kind = RendererKind::kPpll, .fragment_memory = 15});
  renderer.SetField(OneTetField());
  const RenderView view = FourViews(9, 9)[0];
  try {
    renderer.Render(view, 1);
    FAIL() << "two faces in 15 bytes";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("2 faces, which need 16 bytes"));
    EXPECT_THAT(error.what(), ::testing::HasSubstr("raise the fragment memory"));
  }
}

TEST_F(RendererTest, ListsOfBatchesThatAreNoTileAreABug) {
  ProbedRenderer& renderer = MakeRenderer({.kind = RendererKind::kPpll});
  EXPECT_TRUE(renderer.NeedsTiles());
  renderer.SetField(OneTetField());
  const RenderView view = FourViews(16, 16)[0];
  const RayBlock scattered[] = {{0, 0, 0}, {0, 8, 0}};
  EXPECT_THROW(renderer.MarchBlocks(view, scattered), BugError);
}

// Tiles of jittered rays, from the middle of the image, in a mesh whose subdivision must not
// matter.
TEST_F(RendererTest, JitteredRaysAreTheSameInEveryMeshOfTheBox) {
  std::vector<std::vector<double>> losses;
  for (int points : {0, 400}) {
    ProbedRenderer& renderer =
        MakeRenderer({.kind = RendererKind::kPpll, .stop_transmittance = 0.0f});
    renderer.SetField(ConstantField(RandomBoxMesh(points, 84), 1.5f, glm::vec3(0.5f)));
    const RenderView view = LookAt({0.1, 0.4, 0.5}, {0.3, 0.6, 0.9}, 32, 24);
    renderer.SetTargets(std::vector{view},
                        std::vector{TargetImage{32, 24, std::vector<uint32_t>(32 * 24, 0)}});
    std::vector<RayBlock> tile;
    for (uint32_t y = 5; y < 13; y += 2) {
      for (uint32_t x = 7; x < 23; x += 4) tile.push_back({0, x, y});
    }
    losses.emplace_back();
    TrainingBatch step{.blocks = tile, .jitter_px = 2.0f};
    for (uint32_t seed = 0; seed < 10; ++seed) {
      step.seed = seed;
      losses.back().push_back(renderer.Step(step, kStandingUpdate).loss);
    }
    EXPECT_NE(losses.back()[2], losses.back()[3]);
  }
  for (size_t i = 2; i < 10; ++i) EXPECT_NEAR(losses[0][i], losses[1][i], 1e-5 * losses[0][i]);
}

TEST_F(RendererTest, StepsOverTilesLowerTheLoss) {
  ProbedRenderer& renderer = MakeRenderer({.kind = RendererKind::kPpll});
  const RadianceField truth = RandomField(40, 85, 6.0f);
  renderer.SetField(truth);
  const std::vector<RenderView> views = FourViews(20, 14);
  std::vector<TargetImage> targets;
  for (const RenderView& view : views) {
    const RenderedImage image = renderer.Render(view, 1);
    TargetImage target{20, 14, {}};
    for (size_t i = 0; i < image.color_srgb.size(); ++i) {
      const glm::uvec4 bytes(
          255.0f * glm::clamp(glm::vec4(image.color_srgb[i], 1.0f - image.transmittance[i]), 0.0f,
                              1.0f) +
          0.5f);
      target.rgba8.push_back(bytes.r | bytes.g << 8 | bytes.b << 16 | bytes.a << 24);
    }
    targets.push_back(target);
  }
  renderer.SetTargets(views, targets);
  renderer.SetField(ConstantField(truth.mesh, 0.2f, glm::vec3(0.5f)));
  const std::vector<double> losses = LearnPictures(renderer, views, 200);
  const auto mean_of_12 = [&](size_t first) {
    double sum = 0;
    for (size_t i = 0; i < 12; ++i) sum += losses[first + i] / 12;
    return sum;
  };
  EXPECT_LT(mean_of_12(188), 0.03 * mean_of_12(2));
}

}  // namespace
}  // namespace tetrec::test
