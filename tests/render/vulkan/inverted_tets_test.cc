// Meshes that moves by the article's method have broken: renderers do what they can.
#include "core/error.h"
#include "mesh/boundary.h"
#include "render/reference_loss.h"
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tetrec::test {
namespace {

constexpr int kInvertedWidth = 40, kInvertedHeight = 32;

// A field whose inner vertices were moved by about `most`, without regard for tets.
RadianceField Jumbled(float most) {
  RadianceField field = RandomField(150, 42, 6.0f);
  const std::vector<uint8_t> on_boundary = BoundaryVertices(field.mesh);
  std::mt19937 random(5);
  std::normal_distribution<float> normal(0.0f, most);
  for (size_t v = 0; v < on_boundary.size(); ++v) {
    const glm::vec3 move(normal(random), normal(random), normal(random));
    if (!on_boundary[v]) field.mesh.positions[v] += move;
  }
  return field;
}

class InvertedTetsTest : public EveryRendererTest {
 protected:
  std::vector<RenderView> views_ = ThreeViews(kInvertedWidth, kInvertedHeight);
  std::vector<RayBlock> blocks_ = AllBlocks(views_[1].camera, 1);
};

INSTANTIATE_TEST_SUITE_P(, InvertedTetsTest, kEveryRenderer, RendererName);

TEST_P(InvertedTetsTest, AreRefusedUnlessTheyAreExpected) {
  const RadianceField field = Jumbled(0.3f);
  EXPECT_GT(CountDegenerateTets(field.mesh), field.mesh.tets.size() / 10);
  EXPECT_THROW(MakeRenderer({}).SetField(field), DataError);
}

TEST_P(InvertedTetsTest, LeaveImagesAndGradientsFinite) {
  for (const float most : {0.05f, 0.3f, 3.0f}) {
    const RadianceField field = Jumbled(most);
    RendererOptions options;
    options.AcceptInvertedTets();
    // No exact order is known once vertices have left the hull.
    if (GetParam() == RendererKind::kProjection) options.order = VisibilityOrder::kCentroid;
    ProbedRenderer& renderer = MakeRenderer(options);
    renderer.SetField(field);
    for (const RenderView& view : views_) {
      const RenderedImage image = renderer.Render(view, 1);
      for (size_t i = 0; i < image.color_srgb.size(); ++i) {
        ASSERT_TRUE(std::isfinite(glm::dot(image.color_srgb[i], glm::vec3(1.0f)))) << most;
        ASSERT_TRUE(image.transmittance[i] >= 0.0f && image.transmittance[i] <= 1.0f) << most;
      }
    }
    renderer.SetTargets(
        views_,
        std::vector<TargetImage>(
            views_.size(), {kInvertedWidth, kInvertedHeight,
                            std::vector<uint32_t>(kInvertedWidth * kInvertedHeight, 0x7F405060u)}));
    for (int i = 0; i < 3; ++i) {
      renderer.Step({.blocks = blocks_, .parts = GradientParts::kColorDensityPosition}, {});
    }
    for (const glm::dvec3& gradient : renderer.TakePositionGradients().position) {
      ASSERT_TRUE(std::isfinite(gradient.x + gradient.y + gradient.z)) << most;
    }
    for (const float parameter : renderer.ReadState().parameters) {
      ASSERT_TRUE(std::isfinite(parameter)) << most;
    }
  }
}

}  // namespace
}  // namespace tetrec::test
