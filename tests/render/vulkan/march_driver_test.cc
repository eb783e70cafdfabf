// Driver faults: values must not depend on which rays share a group.
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace tetrec::test {
namespace {

// Here, neighbouring rays of a block leave the march after very different numbers of steps.
RenderView LongAndShortRays() { return LookAt({0.9, 1.4, -0.6}, {0.0, 0.3, 0.6}, 96, 64); }

// lavapipe 22.3 gave up to a fifth of such rays wrong colours after a loop left by `break`.
TEST_F(RendererTest, RaysInShuffledOrderGiveTheSameBits) {
  for (float stop : {0.0f, 1e-3f}) {
    ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = stop});
    renderer.SetField(RandomField(2000, 21, 12.0f));
    const RenderView view = LongAndShortRays();
    // Every ray as the first of its own block, so that its neighbours in the group are different.
    std::vector<RayBlock> natural = AllBlocks(view.camera), alone;
    for (uint32_t y = 0; y < 64; ++y) {
      for (uint32_t x = 0; x < 96; ++x) alone.push_back({0, x, y});
    }
    std::shuffle(alone.begin(), alone.end(), std::mt19937(1));
    std::vector<RayBlock> shuffled = natural;
    std::shuffle(shuffled.begin(), shuffled.end(), std::mt19937(2));

    std::vector<glm::uvec4> expected(96 * 64);
    const auto colors = renderer.MarchBlocks(view, natural);
    for (size_t r = 0; r < colors.size(); ++r) {
      const RayBlock& block = natural[r / 8];
      expected[(block.y + r % 8 / 4) * 96 + block.x + r % 4] = std::bit_cast<glm::uvec4>(colors[r]);
    }
    for (const std::vector<RayBlock>& blocks : {shuffled, alone}) {
      const auto others = renderer.MarchBlocks(view, blocks);
      for (size_t r = 0; r < others.size(); ++r) {
        const size_t x = blocks[r / 8].x + r % 4, y = blocks[r / 8].y + r % 8 / 4;
        if (x >= 96 || y >= 64) continue;
        ASSERT_EQ(std::bit_cast<glm::uvec4>(others[r]), expected[y * 96 + x])
            << "pixel " << x << ", " << y;
      }
    }
  }
}

TEST_F(RendererTest, ConstantColourComesBackTimesTheOpacity) {
  const glm::vec3 color(0.25f, 0.5f, 1.0f);
  for (float stop : {0.0f, 1e-3f}) {
    RadianceField field = RandomField(2000, 22, 12.0f);
    std::fill(field.color_srgb.begin(), field.color_srgb.end(), color);
    ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = stop});
    renderer.SetField(field);
    const RenderView view = LongAndShortRays();
    for (const glm::vec4& ray : renderer.MarchBlocks(view, AllBlocks(view.camera))) {
      // 30 segments, each weight with a relative error of 1e-6.
      const float opacity = -std::expm1(-ray.a);
      ASSERT_NEAR(glm::distance(glm::vec3(ray), opacity * color), 0.0f, 3e-6f) << "depth " << ray.a;
    }
  }
}

TEST_F(RendererTest, RaysOutsideThePictureGiveNothing) {
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetField(RandomField(50, 23, 12.0f));
  const RenderView view = LookAt({0.1, 0.4, 0.5}, {0.0, 0.3, 0.6}, 5, 3);
  const auto colors = renderer.MarchBlocks(view, AllBlocks(view.camera));
  ASSERT_EQ(colors.size(), 4u * 8u);
  EXPECT_GT(colors[0].a, 0.0f);  // the camera is inside: every ray hits
  EXPECT_EQ(colors[3 * 8 + 1], glm::vec4(0.0f));
  EXPECT_EQ(colors[2 * 8 + 4], glm::vec4(0.0f));
}

// Float atomics add gradients in any order; a wrong ray would change them by its whole share.
TEST_F(RendererTest, BackwardPassesGiveTheSameGradientEachTime) {
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetField(RandomField(2000, 24, 12.0f));
  const RenderView view = LongAndShortRays();
  const std::vector<glm::vec4> g(96 * 64, glm::vec4(1.0f, -0.5f, 0.25f, 2.0f));
  const FieldGradient first = renderer.Backpropagate(view, g),
                      second = renderer.Backpropagate(view, g);
  for (size_t v = 0; v < first.density.size(); ++v) {
    ASSERT_NEAR(first.density[v], second.density[v], 1e-4f * std::abs(first.density[v]) + 1e-4f);
  }
}

// In one dispatch it would be 65,792 workgroups, more than every device supports.
TEST_F(RendererTest, APictureLargerThanADispatchIsMarchedWhole) {
  ProbedRenderer& renderer = MakeRenderer({.count_steps = true});
  renderer.SetField(RandomField(0, 25, 12.0f));
  constexpr int kSide = 2048, kRows = 2056;
  // The box fills a few percent of the image, in the middle.
  const RenderView view = LookAt({3.0, 4.0, -5.0}, {0.0, 0.375, 0.625}, kSide, kRows);
  const std::vector<RayBlock> blocks = AllBlocks(view.camera);
  const std::vector<glm::vec4> rays = renderer.MarchBlocks(view, blocks);
  ASSERT_EQ(rays.size(), size_t(kSide) * kRows);
  const RenderCounts counts = renderer.counts();
  EXPECT_EQ(counts.rays, rays.size());
  const auto hits =
      std::count_if(rays.begin(), rays.end(), [](const glm::vec4& ray) { return ray.a > 0.0f; });
  EXPECT_GT(double(hits), 0.01 * double(rays.size()));
  // Rays pass 5 or 6 tets, in through one face and out through another.
  EXPECT_GE(counts.hit_rays, uint64_t(hits));
  EXPECT_LT(counts.steps, 7 * counts.hit_rays);
  // Some blocks alone.
  for (size_t i = 0; i < blocks.size(); i += blocks.size() / 40) {
    const std::vector<glm::vec4> alone = renderer.MarchBlocks(view, {&blocks[i], 1});
    for (int r = 0; r < kRaysPerBlock; ++r) {
      EXPECT_EQ(std::bit_cast<glm::uvec4>(alone[r]),
                std::bit_cast<glm::uvec4>(rays[i * kRaysPerBlock + r]));
    }
  }
}

class EveryRenderersBlocks : public EveryRendererTest {};
INSTANTIATE_TEST_SUITE_P(, EveryRenderersBlocks, kEveryVulkanRenderer, RendererName);

// 135,720 rays are more than one submission takes; each part is a tile again.
TEST_P(EveryRenderersBlocks, ManyAreMarchedInPartsWithTheSameBits) {
  const RenderView view = LookAt({0.9, 1.4, -0.6}, {0.0, 0.3, 0.6}, 348, 390);
  const std::vector<RayBlock> blocks = AllBlocks(view.camera);
  ProbedRenderer& renderer = MakeRenderer({.count_steps = true});
  renderer.SetField(RandomField(20, 26, 12.0f));
  const std::vector<glm::vec4> all = renderer.MarchBlocks(view, blocks);
  const RenderCounts whole = renderer.counts();
  std::vector<glm::vec4> parts;
  const size_t row = 348 / kRayBlockWidth;
  for (size_t first = 0; first < blocks.size(); first += 65 * row) {
    const auto part = renderer.MarchBlocks(view, std::span(blocks).subspan(first, 65 * row));
    parts.insert(parts.end(), part.begin(), part.end());
  }
  ASSERT_EQ(all.size(), parts.size());
  for (size_t r = 0; r < all.size(); ++r) {
    ASSERT_EQ(std::bit_cast<glm::uvec4>(all[r]), std::bit_cast<glm::uvec4>(parts[r])) << r;
  }
  EXPECT_EQ(renderer.counts().rays, 2 * whole.rays);
  EXPECT_EQ(renderer.counts().steps, 2 * whole.steps);
  EXPECT_EQ(whole.lost_rays, 0u);
}

}  // namespace
}  // namespace tetrec::test
