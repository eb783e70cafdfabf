// Vertices that move while a renderer learns.
#include "core/error.h"
#include "geometry/bounds3.h"
#include "mesh/boundary.h"
#include "mesh/locate.h"
#include "mesh/safe_motion.h"
#include "render/reference_loss.h"
#include "render/scenes.h"
#include "render/vulkan/fixed_point.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec::test {
namespace {

constexpr int kMovedWidth = 40, kMovedHeight = 32;

class MovedVerticesTest : public EveryRendererTest {
 protected:
  ProbedRenderer& MakeLearner(const RadianceField& field, bool deterministic = false) {
    ProbedRenderer& renderer =
        MakeRenderer({.stop_transmittance = 0.0f, .deterministic = deterministic});
    renderer.SetField(field);
    std::vector<TargetImage> targets(
        views_.size(), {kMovedWidth, kMovedHeight,
                        std::vector<uint32_t>(kMovedWidth * kMovedHeight, 0x7F405060u)});
    renderer.SetTargets(views_, targets);
    return renderer;
  }

  // The same field with its inner vertices a little elsewhere.
  RadianceField Moved() const {
    RadianceField moved = field_;
    std::mt19937 random(5);
    std::normal_distribution<float> normal(0.0f, 0.01f);
    std::vector<glm::vec3> moves;
    for (size_t v = 0; v < moved.mesh.positions.size(); ++v) {
      moves.emplace_back(normal(random), normal(random), normal(random));
    }
    const std::vector<uint8_t> on_boundary = BoundaryVertices(moved.mesh);
    for (size_t v = 0; v < moves.size(); ++v) {
      if (on_boundary[v]) moves[v] = glm::vec3(0.0f);
    }
    SafeMotion motion = MoveSafely(moved.mesh, moves);
    EXPECT_GT(motion.counts.moved, 20u);
    moved.mesh.positions = std::move(motion.positions);
    return moved;
  }

  // A place that is in one tet before the move and in another after it.
  glm::dvec3 PlaceThatChangesTets(const TetMesh& moved) const {
    std::mt19937 random(6);
    std::uniform_real_distribution<double> share;
    const Bounds3 bounds = BoundsOf(moved.positions);
    for (int i = 0; i < 1000; ++i) {
      const glm::dvec3 at(share(random), share(random), share(random));
      const glm::dvec3 place = glm::mix(glm::dvec3(bounds.min), glm::dvec3(bounds.max), at);
      const uint32_t before = FindTet(field_.mesh, place), after = FindTet(moved, place);
      if (before != kNoTet && after != kNoTet && before != after) return place;
    }
    ADD_FAILURE() << "no place changes its tet";
    return {};
  }

  // A number of rays of an update whose sums of positions count in other quanta than those of
  // `rays`.
  uint64_t RaysOfOtherQuanta(uint64_t rays) const {
    const auto quanta = [&](uint64_t r) {
      return ChooseFixedPoint(1.0 / (3.0 * double(r)), r, MostTetsAtVertex(field_.mesh),
                              BoundsOf(field_.mesh.positions).Diagonal())
          .position_quanta;
    };
    for (uint64_t factor = 2; factor < 64; ++factor) {
      if (quanta(factor * rays) != quanta(rays)) return factor * rays;
    }
    ADD_FAILURE() << "all updates have the same quanta";
    return rays;
  }

  TrainingBatch Whole(GradientParts parts) const { return {.blocks = blocks_, .parts = parts}; }

  RadianceField field_ = RandomField(150, 42, 6.0f);
  std::vector<RenderView> views_ = ThreeViews(kMovedWidth, kMovedHeight);
  std::vector<RayBlock> blocks_ = AllBlocks(views_[1].camera, 1);
};

INSTANTIATE_TEST_SUITE_P(, MovedVerticesTest, kEveryRenderer, RendererName);

// One camera stands inside the mesh, right beside a face that moves past it.
TEST_P(MovedVerticesTest, ShowWhatAFieldSetThereShows) {
  const RadianceField moved = Moved();
  views_[1].cam_from_world.translation =
      -(views_[1].cam_from_world.rotation * PlaceThatChangesTets(moved.mesh));
  ProbedRenderer& renderer = MakeLearner(field_);
  ProbedRenderer& other = MakeLearner(moved);
  renderer.MoveVertices(moved.mesh.positions);
  EXPECT_EQ(renderer.mesh().positions, moved.mesh.positions);
  const StepResult loss = renderer.Forward(Whole(GradientParts::kColorDensity));
  EXPECT_EQ(loss.loss, other.Forward(Whole(GradientParts::kColorDensity)).loss);
  for (const RenderView& view : views_) {
    const RenderedImage image = renderer.Render(view, 1), expected = other.Render(view, 1);
    EXPECT_EQ(image.color_srgb, expected.color_srgb);
    EXPECT_EQ(image.transmittance, expected.transmittance);
  }
  EXPECT_EQ(renderer.ReadState().parameters, other.ReadState().parameters);
  EXPECT_EQ(renderer.counts().lost_rays, 0u);
}

TEST_P(MovedVerticesTest, StepsForMotionSumTheSameGradients) {
  AdamUpdate still;
  still.color_rate = still.density_rate = 0;
  std::vector<GradientSums> sums;
  for (const GradientParts parts : {GradientParts::kColorDensityPosition, GradientParts::kMotion}) {
    ProbedRenderer& renderer = MakeLearner(field_);
    renderer.Step(Whole(parts), still);
    sums.push_back(renderer.TakePositionGradients());
  }
  ASSERT_EQ(sums[0].position.size(), field_.mesh.positions.size());
  ASSERT_EQ(sums[1].position.size(), sums[0].position.size());
  double difference = 0, size = 0;
  for (size_t v = 0; v < sums[0].position.size(); ++v) {
    const glm::dvec3 between = sums[1].position[v] - sums[0].position[v];
    difference += glm::dot(between, between);
    size += glm::dot(sums[0].position[v], sums[0].position[v]);
  }
  EXPECT_GT(size, 0.0);
  EXPECT_LT(std::sqrt(difference / size), 1e-5);
}

TEST_P(MovedVerticesTest, StepsSumTheGradientsOfTheirBatches) {
  ProbedRenderer& parts = MakeLearner(field_);
  parts.Forward(Whole(GradientParts::kColorDensity));
  parts.Backward(GradientParts::kColorDensityPosition);
  const GradientSums expected = parts.TakeGradients();
  ProbedRenderer& renderer = MakeLearner(field_);
  EXPECT_TRUE(renderer.TakePositionGradients().position.empty());
  renderer.Step(Whole(GradientParts::kColorDensity), {});
  EXPECT_TRUE(renderer.TakePositionGradients().position.empty());
  AdamUpdate still;
  still.color_rate = still.density_rate = 0;
  renderer.SetField(field_);
  for (int i = 0; i < 3; ++i) renderer.Step(Whole(GradientParts::kColorDensityPosition), still);
  const GradientSums sums = renderer.TakePositionGradients();
  EXPECT_TRUE(sums.values.empty());
  ASSERT_EQ(sums.position.size(), expected.position.size());
  double difference = 0, size = 0;
  for (size_t v = 0; v < expected.position.size(); ++v) {
    const glm::dvec3 three = 3.0 * expected.position[v];
    difference += glm::dot(sums.position[v] - three, sums.position[v] - three);
    size += glm::dot(three, three);
    EXPECT_NEAR(sums.absolute_position[v], 3.0 * expected.absolute_position[v],
                1e-4 * expected.absolute_position[v] + 1e-9);
  }
  EXPECT_GT(size, 0.0);
  EXPECT_LT(std::sqrt(difference / size), 1e-4);  // float sums in any order
  EXPECT_TRUE(renderer.TakePositionGradients().position.empty());
}

// With batches of two sizes, whose sums count in different quanta.
TEST_P(MovedVerticesTest, FixedPointSumsAreThoseOfFloats) {
  AdamUpdate still;
  still.color_rate = still.density_rate = 0;
  const uint64_t rays = blocks_.size() * kRaysPerBlock, other_rays = RaysOfOtherQuanta(rays);
  std::vector<GradientSums> sums;
  for (const bool deterministic : {false, true}) {
    ProbedRenderer* renderer = nullptr;
    try {
      renderer = &MakeLearner(field_, deterministic);
    } catch (const EnvironmentError& error) {
      GTEST_SKIP() << error.what();
    }
    TrainingBatch batch = Whole(GradientParts::kColorDensityPosition);
    for (uint64_t i = 0; i < kMostSummedBatches; ++i) {
      batch.update_rays = i < 10 ? rays : other_rays;
      renderer->Step(batch, still);
    }
    sums.push_back(renderer->TakePositionGradients());
    EXPECT_EQ(renderer->counts().clamped_addends, 0u);
  }
  double difference = 0, size = 0;
  for (size_t v = 0; v < sums[0].position.size(); ++v) {
    const glm::dvec3 error = sums[1].position[v] - sums[0].position[v];
    difference += glm::dot(error, error);
    size += glm::dot(sums[0].position[v], sums[0].position[v]);
  }
  EXPECT_LT(std::sqrt(difference / size), 1e-4);
}

TEST_P(MovedVerticesTest, AnotherFieldHasNoSumsOfTheOneBefore) {
  ProbedRenderer& renderer = MakeLearner(field_);
  renderer.Step(Whole(GradientParts::kColorDensityPosition), {});
  renderer.SetField(RandomField(60, 43, 6.0f));
  EXPECT_TRUE(renderer.TakePositionGradients().position.empty());
}

}  // namespace
}  // namespace tetrec::test
