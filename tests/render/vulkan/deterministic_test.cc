// The deterministic mode: fixed-point sums have the same bits in any order, and are correct.
#include "render/create_renderer.h"
#include "render/reference_loss.h"
#include "render/scenes.h"
#include "render/vulkan/fixed_point.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <optional>

namespace tetrec::test {
namespace {

// Sets an environment variable, and restores it at the end.
class WithEnvironment {
 public:
  WithEnvironment(const char* name, const char* value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    setenv(name, value, 1);
  }
  ~WithEnvironment() {
    if (before_) {
      setenv(name_, before_->c_str(), 1);
    } else {
      unsetenv(name_);
    }
  }
  WithEnvironment(const WithEnvironment&) = delete;
  WithEnvironment& operator=(const WithEnvironment&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

// Every renderer; skipped if the device cannot add 64-bit integers.
class DeterministicTest : public EveryRendererTest {
 protected:
  void SetUp() override {
    RendererTest::SetUp();
    if (IsSkipped()) return;
    try {
      CreateProbedRenderer({.deterministic = true});
    } catch (const EnvironmentError& error) {
      GTEST_SKIP() << error.what();
    }
  }
};

INSTANTIATE_TEST_SUITE_P(Deterministic, DeterministicTest, kEveryRenderer, RendererName);

// Without the reference, which sums in one order and has no fixed point.
using FixedPointTest = DeterministicTest;

INSTANTIATE_TEST_SUITE_P(Deterministic, FixedPointTest, kEveryVulkanRenderer, RendererName);

template <class T>
bool SameBits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

bool SameBits(const TetScores& a, const TetScores& b) {
  return SameBits(a.errors, b.errors) && SameBits(a.light, b.light);
}

void ExpectSameBits(const FieldState& a, const FieldState& b) {
  EXPECT_TRUE(SameBits(a.parameters, b.parameters));
  EXPECT_TRUE(SameBits(a.first_moment, b.first_moment));
  EXPECT_TRUE(SameBits(a.second_moment, b.second_moment));
}

constexpr int kDeterministicWidth = 40, kDeterministicHeight = 30;

void SetGreyTargets(ProbedRenderer& renderer) {
  const TargetImage grey{
      kDeterministicWidth, kDeterministicHeight,
      std::vector<uint32_t>(kDeterministicWidth * kDeterministicHeight, 0xFF808080u)};
  renderer.SetTargets(ThreeViews(kDeterministicWidth, kDeterministicHeight),
                      std::vector<TargetImage>(3, grey));
}

struct Learned {
  FieldState state;
  TetScores scores;
};

// The state of a field after a few steps. `order` selects the order of every step's blocks; steps
// of tiles have one order only. At step `read_back_at` the state is read and set again.
Learned Learn(ProbedRenderer& renderer, uint32_t order, uint32_t read_back_at = 0) {
  const RadianceField start = RandomField(300, 71, 6.0f);
  renderer.SetField(start);
  SetGreyTargets(renderer);
  std::vector<RayBlock> blocks = BlocksOf(ThreeViews(kDeterministicWidth, kDeterministicHeight));
  for (uint32_t i = 1; i <= 9; ++i) {
    std::mt19937 random(order + i);
    if (order > 0) std::shuffle(blocks.begin(), blocks.end(), random);
    const auto tile =
        AllBlocks(ThreeViews(kDeterministicWidth, kDeterministicHeight)[i % 3].camera, i % 3);
    renderer.Step({.blocks = renderer.NeedsTiles() ? tile : blocks,
                   .background_srgb = glm::vec3(0.3f),
                   .jitter_px = renderer.NeedsTiles() ? 1.0f : 0.0f,
                   .seed = i},
                  {.step = i});
    if (i == read_back_at) renderer.SetState(start.mesh, renderer.ReadState());
  }
  renderer.ClearScores();
  renderer.AddScores({.blocks = blocks}, ScoreKind::kSquaredResidual);
  const TetScores scores = renderer.ReadScores();
  return {renderer.ReadState(), scores};
}

// Lists that do not fit into the memory are made and walked one part at a time; other parts mean
// another order.
TEST_P(DeterministicTest, OrderOfTheRaysAndMemoryDoNotChangeABit) {
  ProbedRenderer& renderer = MakeRenderer({.deterministic = true});
  const Learned natural = Learn(renderer, 0);
  for (uint32_t order : {100u, 200u}) {
    ProbedRenderer& other = MakeRenderer({.deterministic = true, .fragment_memory = 300 * order});
    const Learned shuffled = Learn(other, order);
    ExpectSameBits(natural.state, shuffled.state);
    EXPECT_TRUE(SameBits(natural.scores, shuffled.scores));
    EXPECT_EQ(other.counts().clamped_addends, 0u);
  }
}

// Otherwise the test above would prove nothing.
TEST_P(FixedPointTest, OrderOfTheRaysAndMemoryChangeBitsOfFloatSums) {
  ProbedRenderer& renderer = MakeRenderer();
  ProbedRenderer& other = MakeRenderer({.fragment_memory = 300 * 100});
  EXPECT_FALSE(SameBits(Learn(renderer, 0).state.parameters, Learn(other, 100).state.parameters));
}

// Rays have the same bits in whatever order fragments arrive.
TEST_P(DeterministicTest, PicturesAndGradientsAreTheSameBitsEveryTime) {
  const RadianceField field = RandomField(300, 79, 8.0f);
  std::vector<RenderedImage> images;
  std::vector<FieldGradient> gradients;
  for (const char* threads : {"1", "2", "4"}) {
    const WithEnvironment environment("LP_NUM_THREADS", threads);
    ProbedRenderer& renderer = MakeRenderer({.deterministic = true});
    renderer.SetField(field);
    for (const RenderView& view : ThreeViews(37, 27)) {
      images.push_back(renderer.Render(view, 2));
      const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 80);
      gradients.push_back(renderer.Backpropagate(view, std::vector<glm::vec4>(g.begin(), g.end()),
                                                 GradientParts::kColorDensityPosition));
    }
  }
  for (size_t i = 3; i < images.size(); ++i) {
    EXPECT_TRUE(SameBits(images[i].color_srgb, images[i % 3].color_srgb));
    EXPECT_TRUE(SameBits(images[i].transmittance, images[i % 3].transmittance));
    EXPECT_TRUE(SameBits(gradients[i].color_srgb, gradients[i % 3].color_srgb));
    EXPECT_TRUE(SameBits(gradients[i].density, gradients[i % 3].density));
    EXPECT_TRUE(SameBits(gradients[i].position, gradients[i % 3].position));
    EXPECT_TRUE(SameBits(gradients[i].absolute_position, gradients[i % 3].absolute_position));
  }
}

// As on a GPU with memory of its own.
TEST_P(DeterministicTest, CopiesThroughTheStagingAreaDoNotChangeABit) {
  const Learned mapped = Learn(MakeRenderer({.deterministic = true}), 0);
  const Learned copied =
      Learn(MakeRenderer({.device = {.maps_buffers = false}, .deterministic = true}), 0);
  ExpectSameBits(mapped.state, copied.state);
  EXPECT_TRUE(SameBits(mapped.scores, copied.scores));
}

// LP_NUM_THREADS is lavapipe's; other devices ignore it.
TEST_P(DeterministicTest, NumberOfThreadsDoesNotChangeABit) {
  std::vector<Learned> learned;
  for (const char* threads : {"1", "2", "4"}) {
    const WithEnvironment environment("LP_NUM_THREADS", threads);
    learned.push_back(Learn(MakeRenderer({.deterministic = true}), 0));
  }
  for (const Learned& other : learned) {
    ExpectSameBits(learned[0].state, other.state);
    EXPECT_TRUE(SameBits(learned[0].scores, other.scores));
  }
}

TEST_P(DeterministicTest, StateReadAndSetAgainDoesNotChangeABit) {
  ProbedRenderer& renderer = MakeRenderer({.deterministic = true});
  const Learned through = Learn(renderer, 0), resumed = Learn(renderer, 0, 3);
  ExpectSameBits(through.state, resumed.state);
  EXPECT_TRUE(SameBits(through.scores, resumed.scores));
}

double RelativeError(const std::vector<glm::dvec4>& values, const std::vector<glm::dvec4>& truth) {
  double error = 0, norm = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    error += glm::dot(values[i] - truth[i], values[i] - truth[i]);
    norm += glm::dot(truth[i], truth[i]);
  }
  return std::sqrt(error / norm);
}

// With loss gradients as small as those of a mean over many rays, and with large ones.
TEST_P(DeterministicTest, GradientsAreThoseOfTheReferenceAtEveryScale) {
  const RadianceField field = RandomField(100, 72, 8.0f);
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f, .deterministic = true});
  renderer.SetField(field);
  for (float scale : {1e-7f, 1.0f, 1e5f}) {
    for (const RenderView& view : ThreeViews(37, 27)) {
      std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 73);
      for (glm::dvec4& value : g) value = glm::dvec4(glm::vec4(value) * scale);
      const FieldGradient gradient = renderer.Backpropagate(
          view, std::vector<glm::vec4>(g.begin(), g.end()), GradientParts::kColorDensityPosition);
      const ReferenceGradient truth = BackpropagateReference(field, view, g, 0.0);
      std::vector<glm::dvec4> values, positions, true_values, true_positions;
      for (size_t v = 0; v < truth.density.size(); ++v) {
        values.emplace_back(glm::dvec3(gradient.color_srgb[v]), gradient.density[v]);
        positions.emplace_back(glm::dvec3(gradient.position[v]), gradient.absolute_position[v]);
        true_values.emplace_back(truth.color_srgb[v], truth.density[v]);
        true_positions.emplace_back(truth.position[v], truth.absolute_position[v]);
      }
      // The errors of float sums: the quanta are finer than the steps of floats.
      EXPECT_LE(RelativeError(values, true_values), 3e-5) << "scale " << scale;
      EXPECT_LE(RelativeError(positions, true_positions), 1e-4) << "scale " << scale;
    }
  }
  EXPECT_EQ(renderer.counts().clamped_addends, 0u);
}

TEST_P(FixedPointTest, AddendsTooLargeAreCounted) {
  RadianceField field = RandomField(20, 74, 6.0f);
  for (glm::vec3& color : field.color_srgb) color *= 1e6f;
  ProbedRenderer& renderer = MakeRenderer({.deterministic = true});
  renderer.SetField(field);
  SetGreyTargets(renderer);
  renderer.Step(
      {.blocks = AllBlocks(ThreeViews(kDeterministicWidth, kDeterministicHeight)[0].camera)}, {});
  const FieldState state = renderer.ReadState();
  EXPECT_GT(renderer.counts().clamped_addends, 0u);
  for (const float value : state.parameters) EXPECT_TRUE(std::isfinite(value));
}

TEST(FixedPoint, SumsOfTheLargestAddendsStayBelowTheLargestInteger) {
  for (uint64_t rays : {8ull, 4096ull, 8'294'400ull}) {
    for (uint32_t tets : {1u, 24u, 5000u}) {
      const FixedPoint fixed = ChooseFixedPoint(1.0 / (3.0 * double(rays)), rays, tets, 2.5);
      const double most = double(kMostSummedBatches) * double(rays) * tets;
      EXPECT_LE(double(fixed.largest_quanta) * most, 0x1p62);
      EXPECT_GT(double(fixed.largest_quanta) * most, 0x1p61);
      // 64 times a ray's own gradient still fits.
      EXPECT_LE(fixed.color_quanta * 64.0 / (3.0 * double(rays)), fixed.largest_quanta);
    }
  }
}

// The same mesh in other units of length gives the same counts.
TEST(FixedPoint, QuantaScaleWithTheWorld) {
  const FixedPoint metres = ChooseFixedPoint(1e-4, 4096, 32, 2.0),
                   other = ChooseFixedPoint(1e-4, 4096, 32, 2048.0);
  EXPECT_EQ(other.color_quanta, metres.color_quanta);
  EXPECT_EQ(other.density_quanta * 1024.0f, metres.density_quanta);
  EXPECT_EQ(other.position_quanta, metres.position_quanta * 1024.0f);
}

TEST(FixedPoint, MostTetsAtAVertexIsTheLargestStar) {
  TetMesh mesh;
  mesh.positions.resize(6);
  mesh.tets = {{0, 1, 2, 3}, {0, 1, 2, 4}, {1, 2, 4, 5}};
  EXPECT_EQ(MostTetsAtVertex(mesh), 3u);
}

}  // namespace
}  // namespace tetrec::test
