// Every renderer against the reference renderer: images and gradients of random fields.
#include "render/reference_loss.h"
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec::test {
namespace {

// Small meshes with large images, and one of 20,000 tets with a small image: a second each.
const Scene kScenes[] = {{0, 1, 45, 33},   {0, 2, 45, 33},   {20, 3, 45, 33},
                         {300, 4, 37, 27}, {300, 5, 37, 27}, {3000, 6, 21, 15}};

INSTANTIATE_TEST_SUITE_P(Pictures, EveryRendererTest, kEveryRenderer, RendererName);

TEST_P(EveryRendererTest, PicturesAreThoseOfTheReference) {
  for (float stop : {0.0f, 1e-3f}) {
    ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = stop});
    for (const Scene& scene : kScenes) {
      const RadianceField field = RandomField(scene.points, scene.seed, 10.0f);
      renderer.SetField(field);
      for (const RenderView& view : ThreeViews(scene.width, scene.height)) {
        const RenderedImage image = renderer.Render(view, 1);
        const ReferenceImage truth = RenderReference(field, view, stop);
        for (size_t i = 0; i < truth.color_srgb.size(); ++i) {
          ASSERT_NEAR(glm::distance(glm::dvec3(image.color_srgb[i]), truth.color_srgb[i]), 0.0,
                      kPictureTolerance)
              << scene.points << " points, seed " << scene.seed << ", pixel " << i;
          ASSERT_NEAR(image.transmittance[i], std::exp(-truth.optical_depth[i]), kPictureTolerance)
              << scene.points << " points, seed " << scene.seed << ", pixel " << i;
        }
      }
      EXPECT_EQ(renderer.counts().lost_rays, 0u);
    }
  }
}

// Also if lists are made one part at a time. Images consist of whole blocks, because the Vulkan
// renderers also count rays outside the image.
TEST_P(EveryRendererTest, CountsAreThoseOfTheMarch) {
  for (const Scene& scene : {Scene{0, 2, 44, 34}, Scene{300, 4, 44, 34}}) {
    for (float stop : {0.0f, 1e-3f}) {
      for (uint64_t memory : {20'000ull, 512ull << 20}) {
        const RendererOptions options{
            .stop_transmittance = stop, .count_steps = true, .fragment_memory = memory};
        const RadianceField field = RandomField(scene.points, scene.seed, 10.0f);
        ProbedRenderer& renderer = MakeRenderer(options);
        ProbedRenderer& march = RendererTest::MakeRenderer(options);
        renderer.SetField(field);
        march.SetField(field);
        for (const RenderView& view : ThreeViews(scene.width, scene.height)) {
          renderer.Render(view, 1);
          march.Render(view, 1);
        }
        const RenderCounts counts = renderer.counts(), truth = march.counts();
        EXPECT_EQ(counts.rays, truth.rays);
        EXPECT_EQ(counts.lost_rays, 0u);
        EXPECT_EQ(counts.hit_rays, truth.hit_rays);
        // Rounding may decide which of two tets a ray at an edge passes, or when it stops.
        EXPECT_NEAR(double(counts.steps), double(truth.steps), 1e-4 * double(truth.steps));
      }
    }
  }
}

TEST_P(EveryRendererTest, SeveralRaysAPixelAreAveraged) {
  const RadianceField field = RandomField(50, 7, 5.0f);
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetField(field);
  const RenderView view = ThreeViews(13, 7)[0];
  RenderView finer = view;
  for (double* value : {&finer.camera.fx, &finer.camera.fy, &finer.camera.cx, &finer.camera.cy}) {
    *value *= 2.0;
  }
  finer.camera.width *= 2, finer.camera.height *= 2;
  const RenderedImage image = renderer.Render(view, 2), fine = renderer.Render(finer, 1);
  for (int y = 0; y < 7; ++y) {
    for (int x = 0; x < 13; ++x) {
      glm::vec3 mean(0.0f);
      for (int k = 0; k < 4; ++k)
        mean += 0.25f * fine.color_srgb[(2 * y + k / 2) * 26 + 2 * x + k % 2];
      EXPECT_NEAR(glm::distance(image.color_srgb[y * 13 + x], mean), 0.0f, 1e-6f);
    }
  }
}

// The largest difference divided by the largest value.
double RelativeError(const std::vector<double>& values, const std::vector<double>& truth) {
  double difference = 0, largest = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    difference = std::max(difference, std::abs(values[i] - truth[i]));
    largest = std::max(largest, std::abs(truth[i]));
  }
  return difference / largest;
}

void ExpectSameGradient(const FieldGradient& gradient, const ReferenceGradient& truth,
                        double tolerance = kGradientTolerance) {
  std::vector<double> color, true_color;
  for (size_t v = 0; v < truth.density.size(); ++v) {
    for (int i = 0; i < 3; ++i) {
      color.push_back(gradient.color_srgb[v][i]);
      true_color.push_back(truth.color_srgb[v][i]);
    }
  }
  EXPECT_LE(RelativeError(color, true_color), tolerance);
  const std::vector<double> density(gradient.density.begin(), gradient.density.end());
  EXPECT_LE(RelativeError(density, truth.density), tolerance);
}

TEST_P(EveryRendererTest, GradientsAreThoseOfTheReferenceWithEitherKindOfAtomics) {
  for (bool float_atomics : {true, false}) {
    for (float stop : {0.0f, 1e-3f}) {
      ProbedRenderer& renderer =
          MakeRenderer({.device = {.float_atomics = float_atomics}, .stop_transmittance = stop});
      for (const Scene& scene : kScenes) {
        SCOPED_TRACE(::testing::Message() << scene.points << " points, seed " << scene.seed
                                          << ", stop " << stop << ", atomics " << float_atomics);
        const RadianceField field = RandomField(scene.points, scene.seed, 10.0f);
        renderer.SetField(field);
        for (const RenderView& view : ThreeViews(scene.width, scene.height)) {
          const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, scene.seed);
          const std::vector<glm::vec4> g_float(g.begin(), g.end());
          ExpectSameGradient(renderer.Backpropagate(view, g_float),
                             BackpropagateReference(field, view, g, stop));
        }
      }
    }
  }
}

RendererOptions WithIntegral(const std::string& words) {
  RendererOptions options;
  options.integral = ParseIntegral(words);
  // No early stop: in dense fields, rounding decides which tet is a ray's last.
  options.stop_transmittance = 0.0f;
  return options;
}

const char* const kIntegrals[] = {"exact", "mean", "split:1", "split:4", "split:16"};

// Densities up to 40 also make thick segments, which only the exact integral treats separately.
TEST_P(EveryRendererTest, EveryIntegralHasThePictureAndTheGradientsOfTheReference) {
  for (const char* words : kIntegrals) {
    const RendererOptions options = WithIntegral(words);
    ProbedRenderer& renderer = MakeRenderer(options);
    for (const Scene& scene : {Scene{0, 2, 29, 21}, Scene{20, 3, 29, 21}, Scene{300, 4, 21, 15}}) {
      SCOPED_TRACE(::testing::Message() << words << ", " << scene.points << " points");
      const RadianceField field = RandomField(scene.points, scene.seed, 40.0f);
      renderer.SetField(field);
      for (const RenderView& view : ThreeViews(scene.width, scene.height)) {
        const RenderedImage image = renderer.Render(view, 1);
        const ReferenceImage truth =
            RenderReference(field, view, options.stop_transmittance, options.integral);
        for (size_t i = 0; i < truth.color_srgb.size(); ++i) {
          // Four times the density of the fields above, hence four times their tolerance.
          ASSERT_NEAR(glm::distance(glm::dvec3(image.color_srgb[i]), truth.color_srgb[i]), 0.0,
                      4 * kPictureTolerance)
              << "pixel " << i;
        }
        const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, scene.seed);
        const std::vector<glm::vec4> g_float(g.begin(), g.end());
        ExpectSameGradient(
            renderer.Backpropagate(view, g_float),
            BackpropagateReference(field, view, g, options.stop_transmittance, options.integral),
            8 * kGradientTolerance);  // the device computes densities from their logarithms by exp
      }
    }
  }
}

// Guards against an integral option that is ignored, with which the test above would pass.
TEST(ReferenceRenderer, MorePartsComeNearerToTheExactPicture) {
  const RadianceField field = RandomField(20, 3, 40.0f);
  const RenderView view = ThreeViews(29, 21)[0];
  const ReferenceImage exact = RenderReference(field, view, 0.0);
  const auto error = [&](const char* words) {
    const ReferenceImage image = RenderReference(field, view, 0.0, ParseIntegral(words));
    double worst = 0;
    for (size_t i = 0; i < exact.color_srgb.size(); ++i) {
      worst = std::max(worst, glm::distance(image.color_srgb[i], exact.color_srgb[i]));
      // The opacity is exact in all of them.
      EXPECT_EQ(image.optical_depth[i], exact.optical_depth[i]);
    }
    return worst;
  };
  EXPECT_EQ(error("mean"), error("split:1"));
  EXPECT_GT(error("mean"), 1e-2);
  // Once parts are thin, four times as many leave a sixteenth of the error; half of that gain is
  // required.
  EXPECT_LT(error("split:4"), error("mean") / 4);
  EXPECT_LT(error("split:16"), error("split:4") / 8);
  EXPECT_LT(error("split:64"), error("split:16") / 8);
}

TEST(ReferenceRenderer, GradientsAreFiniteDifferencesOfTheLoss) {
  struct Case {
    uint32_t seed;
    const char* words;
    bool any_sign;
  };
  for (const auto& [seed, words, any_sign] :
       {Case{11u, "exact", false}, Case{12u, "exact", false}, Case{11u, "mean", false},
        Case{12u, "split:3", false}, Case{13u, "exact", true}}) {
    const IntegralOptions integral = ParseIntegral(words);
    RadianceField field = RandomField(12, seed, 8.0f);
    for (float& density : field.density) density += 0.1f;  // not flat where values step down
    if (any_sign) field = WithAnySign(std::move(field), seed);
    for (const RenderView& view : ThreeViews(12, 9)) {
      const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, seed);
      const ReferenceGradient gradient = BackpropagateReference(field, view, g, 0.0, integral);
      double largest = 0;
      for (double d : gradient.density) largest = std::max(largest, std::abs(d));
      for (size_t v = 0; v < field.density.size(); ++v) {
        // Central differences have an error of h^2 / 6 L''' (h = 1e-2, L''' of order l^2 L'), the
        // quadrature of the derivatives one of 3e-6. Where a value passes through 0 in a step, L'
        // bends.
        EXPECT_NEAR(CentralDifference(field, field.density[v], 1e-2f, view, g, integral),
                    gradient.density[v], (any_sign ? 3e-4 : 3e-5) * largest)
            << "density of vertex " << v << ", seed " << seed << ", " << words;
        // The image is linear in colour: the only errors are rounding and that of the quadrature.
        EXPECT_NEAR(CentralDifference(field, field.color_srgb[v].y, 0.25f, view, g, integral),
                    gradient.color_srgb[v].y, 1e-5 * std::abs(gradient.color_srgb[v].y) + 1e-6)
            << "green of vertex " << v << ", seed " << seed << ", " << words;
      }
    }
  }
}

TEST(ReferenceRenderer, RaysPassTheWholeBox) {
  for (int points : {0, 40}) {
    const RadianceField field = RandomField(points, 3, 1.0f);
    for (const RenderView& view : ThreeViews(24, 18)) {
      const ReferenceImage image = RenderReference(field, view, 0.0);
      for (int i = 0; i < 24 * 18; ++i) {
        // The cuts of neighbours are equal numbers, so only their sum is rounded.
        EXPECT_NEAR(image.length[i],
                    BoxChord(Eye(view), PixelDirection(view, i % 24, i / 24)).length, 1e-12);
      }
    }
  }
}

}  // namespace
}  // namespace tetrec::test
