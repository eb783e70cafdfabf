// Fields whose values of density are negative in places: every renderer against the reference.
#include "render/reference_loss.h"
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec::test {
namespace {

class SignedDensityTest : public EveryRendererTest {
 protected:
  // Thin segments and thick ones, small and large meshes. In the mesh of seed 4 a ray meets a face
  // so flatly that the position gradients of ppll err by 1e-4 (densities of one sign) to 4e-4.
  std::vector<RadianceField> Fields() const {
    return {WithAnySign(RandomField(20, 3, 10.0f), 1), WithAnySign(RandomField(300, 14, 10.0f), 2),
            WithAnySign(RandomField(300, 5, 300.0f), 3)};
  }
};

INSTANTIATE_TEST_SUITE_P(, SignedDensityTest, kEveryRenderer, RendererName);

// Relative to the norm.
double ErrorOf(const std::vector<glm::vec3>& got, const std::vector<glm::dvec3>& want) {
  double error = 0, size = 0;
  for (size_t i = 0; i < want.size(); ++i) {
    error += glm::dot(glm::dvec3(got[i]) - want[i], glm::dvec3(got[i]) - want[i]);
    size += glm::dot(want[i], want[i]);
  }
  return std::sqrt(error / size);
}

double ErrorOf(const std::vector<float>& got, const std::vector<double>& want) {
  double error = 0, size = 0;
  for (size_t i = 0; i < want.size(); ++i) {
    error += (got[i] - want[i]) * (got[i] - want[i]);
    size += want[i] * want[i];
  }
  return std::sqrt(error / size);
}

TEST_P(SignedDensityTest, PicturesAndDepthsAreThoseOfTheReference) {
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  ProbedRenderer& reference =
      RendererTest::MakeRenderer({.kind = RendererKind::kReference, .stop_transmittance = 0.0f});
  for (const RadianceField& field : Fields()) {
    renderer.SetField(field);
    reference.SetField(field);
    for (const RenderView& view : ThreeViews(37, 27)) {
      const RenderedImage image = renderer.Render(view, 1);
      const ReferenceImage truth = RenderReference(field, view, 0);
      for (size_t i = 0; i < truth.color_srgb.size(); ++i) {
        // As for positive densities, and steeper where values are large.
        ASSERT_NEAR(glm::distance(glm::dvec3(image.color_srgb[i]), truth.color_srgb[i]), 0.0, 2e-4);
      }
      const DepthMap depth = renderer.RenderDepth(view, kHalfLightDepth),
                     want = reference.RenderDepth(view, kHalfLightDepth);
      size_t hits = 0, off = 0;
      for (size_t i = 0; i < want.depth.size(); ++i) {
        hits += want.depth[i] != kNoDepth;
        off += std::abs(depth.depth[i] - want.depth[i]) > 1e-4f;
      }
      EXPECT_GT(hits, 50u);
      EXPECT_LE(off, hits / 50 + 1);
    }
  }
}

TEST_P(SignedDensityTest, GradientsAreThoseOfTheReference) {
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  for (const RadianceField& field : Fields()) {
    renderer.SetField(field);
    for (const RenderView& view : ThreeViews(37, 27)) {
      const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 68);
      const FieldGradient got = renderer.Backpropagate(
          view, std::vector<glm::vec4>(g.begin(), g.end()), GradientParts::kColorDensityPosition);
      const ReferenceGradient truth = BackpropagateReference(field, view, g, 0);
      EXPECT_LE(ErrorOf(got.color_srgb, truth.color_srgb), 1e-4);
      EXPECT_LE(ErrorOf(got.density, truth.density), 1e-4);
      EXPECT_LE(ErrorOf(got.position, truth.position), 2e-4);
    }
  }
}

TEST(ReferenceRenderer, PositionGradientsOfSignedDensityAreFiniteDifferencesOfTheLoss) {
  RadianceField field = WithAnySign(RandomField(6, 14, 8.0f), 4);
  for (const RenderView& view : ThreeViews(12, 9)) {
    const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 69);
    const ReferenceGradient gradient = BackpropagateReference(field, view, g, 0.0);
    double largest = 0;
    for (const glm::dvec3& p : gradient.position) largest = std::max(largest, glm::length(p));
    for (size_t v = 8; v < field.density.size(); ++v) {  // behind the corners of the box
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(CentralDifference(field, field.mesh.positions[v][axis], 1e-5f, view, g),
                    gradient.position[v][axis], 1e-3 * largest)
            << "coordinate " << axis << " of vertex " << v;
      }
    }
  }
}

}  // namespace
}  // namespace tetrec::test
