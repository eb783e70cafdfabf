#include "optimize/article_motion.h"

#include "core/error.h"
#include "mesh/boundary.h"
#include "optimize/small_run.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tetrec {
namespace {

MotionState StateOfVertices(std::vector<float> room) {
  const size_t count = room.size();
  return {.first_moment = std::vector<glm::vec3>(count, glm::vec3(0.0f)),
          .second_moment = std::vector<glm::vec3>(count, glm::vec3(0.0f)),
          .size = std::vector<float>(count, 1.0f),
          .room = std::move(room),
          .counts = {}};
}

OptimizeOptions ArticleOptions(double rate) {
  OptimizeOptions options = SmallRunOptions();
  options.move = MoveChoice::kArticle;
  options.position_rate = rate;
  options.renderer.AcceptInvertedTets();
  return options;
}

TEST(ArticleMotion, AlternatesEpochsOfAllPictures) {
  for (uint64_t step = 1; step <= 5; ++step) {
    EXPECT_FALSE(IsInJointEpoch(step, 5)) << step;
    EXPECT_TRUE(IsInJointEpoch(step + 5, 5)) << step;
    EXPECT_FALSE(IsInJointEpoch(step + 10, 5)) << step;
  }
}

// Adam's first step is the rate in each coordinate, whatever the gradient's size.
TEST(ArticleMotion, MovesEachCoordinateByTheRateAtFirst) {
  MotionState state = StateOfVertices({10.0f, 10.0f, 0.0f, 0.1f});
  const std::vector<glm::dvec3> gradients(4, glm::dvec3(1e-6, -3.0, 0.0));
  const std::vector<glm::vec3> moves = ArticleMoves(gradients, 0.25, state);
  for (const size_t v : {0u, 1u}) {
    EXPECT_NEAR(moves[v].x, -0.25, 1e-6);
    EXPECT_NEAR(moves[v].y, 0.25, 1e-6);
    EXPECT_EQ(moves[v].z, 0.0f);
  }
  EXPECT_EQ(moves[2], glm::vec3(0.0f)) << "of the boundary";
  EXPECT_EQ(moves[3], glm::vec3(0.0f)) << "would have left its room";
  EXPECT_NEAR(state.room[0], 10 - 0.25 * std::sqrt(2.0), 1e-5);
}

// As torch.optim.Adam has it; a coordinate without gradient goes on by its momentum.
TEST(ArticleMotion, FollowsAdam) {
  MotionState state = StateOfVertices({1e9f});
  double first = 0, second = 0;
  for (int step = 1; step <= 30; ++step) {
    const double gradient = step < 20 ? std::sin(double(step)) : 0.0;
    first = 0.9 * first + 0.1 * gradient;
    second = 0.999 * second + 0.001 * gradient * gradient;
    const double expected = -0.01 * (first / (1 - std::pow(0.9, step))) /
                            std::sqrt(second / (1 - std::pow(0.999, step)));
    const std::vector<glm::dvec3> gradients{glm::dvec3(gradient, 0, 0)};
    EXPECT_NEAR(ArticleMoves(gradients, 0.01, state)[0].x, expected, 1e-6) << step;
  }
}

struct ArticleRun : SmallRun {
  explicit ArticleRun(double rate) : SmallRun(ArticleOptions(rate)) {
    PutField(0.1);
    motion.StartIfDue(0.0);
  }
};

TEST(ArticleMotion, StartsAtOnceAndMovesInEverySecondEpochOnly) {
  ArticleRun run(1e-4);
  EXPECT_TRUE(run.motion.has_started());
  const std::vector<glm::vec3> before = run.field.mesh().positions;
  for (int i = 0; i < 5; ++i) run.steps.Take(AtProgress(0.9), false);
  EXPECT_EQ(run.field.mesh().positions, before);
  run.steps.Take(AtProgress(0.9), false);
  EXPECT_NE(run.field.mesh().positions, before);
  EXPECT_TRUE(run.motion.CanResumeAfter(6, 0.9));
  EXPECT_EQ(run.motion.state().motions, 1u);
}

// What the article reports of large rates. The run goes on, and its state can be put back.
TEST(ArticleMotion, BreaksTheMeshByALargeRateAndLeavesTheBoundary) {
  ArticleRun run(0.05);
  const TetMesh before = run.field.mesh();
  EXPECT_EQ(CountDegenerateTets(before), 0u);
  for (int i = 0; i < 30; ++i) run.steps.Take(AtProgress(0.5), false);
  const TetMesh& mesh = run.field.mesh();
  const std::vector<uint8_t> on_boundary = BoundaryVertices(mesh);
  for (size_t v = 0; v < on_boundary.size(); ++v) {
    EXPECT_TRUE(!on_boundary[v] || mesh.positions[v] == before.positions[v]) << v;
  }
  EXPECT_GT(CountDegenerateTets(mesh), mesh.tets.size() / 20);
  EXPECT_THROW(CheckTets(mesh), DataError);
  EXPECT_TRUE(std::isfinite(run.pictures.JudgeField().psnr));
  run.field.PutState(run.field.ReadState());
  run.field.Put(run.field.mesh(), run.field.ReadState());
}

// Even in the middle of an epoch, and with a broken mesh.
TEST(ArticleMotion, ContinuesAsItWouldHave) {
  ArticleRun whole(0.05), first(0.05), second(0.05);
  for (int i = 0; i < 17; ++i) whole.steps.Take(AtProgress(0.5), false);
  for (int i = 0; i < 8; ++i) first.steps.Take(AtProgress(0.5), false);
  EXPECT_GT(CountDegenerateTets(first.field.mesh()), 0u);
  second.steps.Resume(first.steps.iteration(), first.steps.rays());
  second.field.Put(first.field.mesh(), first.field.ReadState());
  second.motion.Resume(first.motion.state());
  for (int i = 0; i < 9; ++i) second.steps.Take(AtProgress(0.5), false);
  EXPECT_EQ(second.field.mesh().positions, whole.field.mesh().positions);
  EXPECT_EQ(second.field.ReadState().parameters, whole.field.ReadState().parameters);
}

TEST(ArticleMotion, EndsARunWhosePositionsAreNotFinite) {
  ArticleRun run(1e-4);
  std::vector<glm::vec3> moves(run.field.mesh().positions.size(), glm::vec3(0.0f));
  moves[3].y = std::numeric_limits<float>::infinity();
  EXPECT_THROW(run.field.MoveVerticesFreely(moves), DataError);
}

TEST(PositionRate, DependsOnHowVerticesMove) {
  OptimizeOptions options;
  EXPECT_EQ(PositionRateOf(options), 0.1);
  options.move = MoveChoice::kArticle;
  EXPECT_EQ(PositionRateOf(options), 2e-5);
  options.position_rate = 3e-3;
  EXPECT_EQ(PositionRateOf(options), 3e-3);
  options.move = MoveChoice::kOff;
  EXPECT_THROW(options.Check(), UsageError);
}

}  // namespace
}  // namespace tetrec
