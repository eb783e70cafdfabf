// Faults of drivers: values must not depend on which rays share a group.
#include "scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace tetrec::test {
namespace {

// Blocks of neighbouring rays leave the march after very different numbers of steps here.
RenderView LongAndShortRays() { return LookAt({0.9, 1.4, -0.6}, {0.0, 0.3, 0.6}, 96, 64); }

// lavapipe 22.3 gave up to a fifth of such rays wrong colours after a loop left by `break`.
TEST_F(RendererTest, RaysInShuffledOrderGiveTheSameBits) {
  for (float stop : {0.0f, 1e-3f}) {
    TrainingRenderer& renderer = MakeRenderer({.stop_transmittance = stop});
    renderer.SetField(RandomField(2000, 21, 12.0f));
    const RenderView view = LongAndShortRays();
    // Every ray as the first of a block of its own: its neighbours in the group are other ones.
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
    TrainingRenderer& renderer = MakeRenderer({.stop_transmittance = stop});
    renderer.SetField(field);
    const RenderView view = LongAndShortRays();
    for (const glm::vec4& ray : renderer.MarchBlocks(view, AllBlocks(view.camera))) {
      // 30 segments, each weight right to 1e-6 of itself.
      const float opacity = -std::expm1(-ray.a);
      ASSERT_NEAR(glm::distance(glm::vec3(ray), opacity * color), 0.0f, 3e-6f) << "depth " << ray.a;
    }
  }
}

TEST_F(RendererTest, RaysOutsideThePictureGiveNothing) {
  TrainingRenderer& renderer = MakeRenderer();
  renderer.SetField(RandomField(50, 23, 12.0f));
  const RenderView view = LookAt({0.1, 0.4, 0.5}, {0.0, 0.3, 0.6}, 5, 3);
  const auto colors = renderer.MarchBlocks(view, AllBlocks(view.camera));
  ASSERT_EQ(colors.size(), 4u * 8u);
  EXPECT_GT(colors[0].a, 0.0f);  // the camera is inside: every ray hits
  EXPECT_EQ(colors[3 * 8 + 1], glm::vec4(0.0f));
  EXPECT_EQ(colors[2 * 8 + 4], glm::vec4(0.0f));
}

// Gradients come from float atomics in any order; a wrong ray would be wrong by its whole share.
TEST_F(RendererTest, BackwardPassesGiveTheSameGradientEachTime) {
  TrainingRenderer& renderer = MakeRenderer();
  renderer.SetField(RandomField(2000, 24, 12.0f));
  const RenderView view = LongAndShortRays();
  const std::vector<glm::vec4> g(96 * 64, glm::vec4(1.0f, -0.5f, 0.25f, 2.0f));
  const FieldGradient first = renderer.Backpropagate(view, g),
                      second = renderer.Backpropagate(view, g);
  for (size_t v = 0; v < first.density.size(); ++v) {
    ASSERT_NEAR(first.density[v], second.density[v], 1e-4f * std::abs(first.density[v]) + 1e-4f);
  }
}

}  // namespace
}  // namespace tetrec::test
