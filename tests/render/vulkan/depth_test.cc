// Depth: where a ray has lost half of its light.
#include "render/reference/render_picture.h"
#include "render/reference_loss.h"
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec::test {
namespace {

class RenderDepthTest : public EveryRendererTest {};
INSTANTIATE_TEST_SUITE_P(, RenderDepthTest, kEveryRenderer, RendererName);

// The distance at which a ray from outside enters the box that every field fills; nothing if it
// misses.
double EntryDistance(const glm::dvec3& eye, const glm::dvec3& direction) {
  double begin = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (direction[axis] == 0) continue;
    const double face = direction[axis] > 0 ? kBoxMin[axis] : kBoxMax[axis];
    begin = std::max(begin, (face - eye[axis]) / direction[axis]);
  }
  return begin;
}

TEST_P(RenderDepthTest, ConstantDensityReachesAnOpticalDepthAfterItsLayer) {
  constexpr float kDensity = 3;
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetField(ConstantField(RandomBoxMesh(100, 8), kDensity, glm::vec3(0.5f)));
  double optical_depth = kHalfLightDepth;
  for (const RenderView& view : ThreeViews(37, 27)) {
    const double layer = optical_depth / kDensity;
    const DepthMap map = renderer.RenderDepth(view, optical_depth);
    optical_depth *= 0.6;
    ASSERT_EQ(map.width, 37);
    ASSERT_EQ(map.height, 27);
    int hits = 0;
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        const glm::dvec3 direction = PixelDirection(view, x, y);
        const double length = BoxChord(Eye(view), direction).length;
        const double distance = EntryDistance(Eye(view), direction) + layer;
        const double cosine = (view.cam_from_world.rotation * direction).z;
        if (std::abs(length - layer) < 1e-5) continue;  // rounding decides
        if (length < layer) {
          EXPECT_EQ(map.At(x, y), kNoDepth) << x << " " << y;
        } else {
          EXPECT_NEAR(map.At(x, y), distance * cosine, 1e-5) << x << " " << y;
          ++hits;
        }
      }
    }
    EXPECT_GT(hits, 50);
  }
  EXPECT_EQ(renderer.counts().lost_rays, 0u);
}

TEST_P(RenderDepthTest, DepthsAreThoseOfTheReference) {
  ProbedRenderer& renderer = MakeRenderer();
  ProbedRenderer& reference = RendererTest::MakeRenderer({.kind = RendererKind::kReference});
  for (const FieldStorage storage : {FieldStorage::kVertex, FieldStorage::kCell}) {
    // Thin segments, and thick ones, which the march integrates apart.
    for (const float density : {10.0f, 1000.0f}) {
      const RadianceField field = RandomField(300, 4, density, storage);
      renderer.SetField(field);
      reference.SetField(field);
      for (const RenderView& view : ThreeViews(37, 27)) {
        const DepthMap got = renderer.RenderDepth(view, kHalfLightDepth),
                       want = reference.RenderDepth(view, kHalfLightDepth);
        const ReferenceImage image = RenderReference(field, view, 0);
        size_t hits = 0, off = 0;
        for (size_t i = 0; i < want.depth.size(); ++i) {
          // A ray that just about loses half of its light may do so anywhere.
          if (std::abs(image.optical_depth[i] - kHalfLightDepth) < 1e-4) continue;
          ASSERT_EQ(got.depth[i] == kNoDepth, want.depth[i] == kNoDepth) << i;
          hits += want.depth[i] != kNoDepth;
          off += std::abs(got.depth[i] - want.depth[i]) > 1e-4f;
        }
        EXPECT_GT(hits, 50u);
        // In nearly empty tets a small error of the optical depth is a long way.
        EXPECT_LE(off, hits / 100);
      }
    }
  }
}

TEST_P(RenderDepthTest, DepthIsMeasuredFromACameraInsideTheField) {
  constexpr float kDensity = 20;
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetField(ConstantField(RandomBoxMesh(100, 9), kDensity, glm::vec3(0.5f)));
  const glm::dvec3 middle = 0.5 * glm::dvec3(kBoxMin + kBoxMax);
  const RenderView view = LookAt(middle, middle + glm::dvec3(0.1, 0.2, 1), 12, 10);
  const DepthMap map = renderer.RenderDepth(view, kHalfLightDepth);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const double cosine = (view.cam_from_world.rotation * PixelDirection(view, x, y)).z;
      EXPECT_NEAR(map.At(x, y), std::log(2.0) / kDensity * cosine, 1e-6);
    }
  }
}

}  // namespace
}  // namespace tetrec::test
