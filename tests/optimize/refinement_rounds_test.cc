#include "optimize/refinement_rounds.h"

#include "optimize/small_run.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

class RefinementRoundsTest : public ::testing::Test {
 protected:
  const ScratchFolder folder_;
  SmallRun run_;
  const GrowthPlan plan_{4, 2000};
  RefinementRounds rounds_{
      run_.options,
      plan_,
      {run_.field, run_.motion, run_.pictures, run_.batches, run_.steps, *run_.renderer},
      folder_ / "best.bin"};
  size_t vertices() const { return run_.field.mesh().positions.size(); }
};

TEST_F(RefinementRoundsTest, AreDueOneAfterAnother) {
  const ScheduleOptions& schedule = run_.options.schedule;
  for (int round = 0; round < plan_.rounds; ++round) {
    const double due = RoundProgress(schedule, plan_, round);
    EXPECT_FALSE(rounds_.IsDue(due - 1e-3));
    ASSERT_TRUE(rounds_.IsDue(due));
    rounds_.Resume({uint32_t(round + 1), 0.0});
  }
  EXPECT_FALSE(rounds_.IsDue(1.0));
}

TEST_F(RefinementRoundsTest, GoOnWithAFieldThatGained) {
  run_.PutField(0.2);
  rounds_.Advance();
  const double first = rounds_.state().best_psnr;
  const size_t refined = vertices();
  EXPECT_GT(refined, WavyBox(0.2).mesh.positions.size());
  run_.PutField(0.4);
  rounds_.Advance();
  EXPECT_EQ(rounds_.state().rounds, 2u);
  EXPECT_GT(rounds_.state().best_psnr, first);
}

TEST_F(RefinementRoundsTest, TakeBackAFieldThatLost) {
  run_.steps.Take(0.0, false);  // so that there are moments
  const std::vector<glm::vec3> positions = run_.field.mesh().positions;
  const FieldState best = run_.field.ReadState();
  rounds_.Advance();
  ASSERT_GT(vertices(), positions.size());
  FieldState worse = run_.field.ReadState();
  for (float& parameter : worse.parameters) parameter = 0.0f;
  run_.field.PutState(worse);
  rounds_.Advance();
  const FieldState now = run_.field.ReadState();
  EXPECT_TRUE(run_.field.mesh().positions == positions);
  EXPECT_TRUE(now.parameters == best.parameters);
  EXPECT_TRUE(now.second_moment == best.second_moment);
  EXPECT_FALSE(rounds_.IsDue(1.0));
}

TEST_F(RefinementRoundsTest, TakeNothingBackWhereNothingJudges) {
  run_.pictures.EndJudgingIfDue(1.0);
  rounds_.Advance();
  run_.PutField(0.0);
  rounds_.Advance();
  EXPECT_EQ(rounds_.state().rounds, 2u);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "best.bin"));
}

// The picture of the judging views does not change by a split, so it does not change by a round.
TEST(RefinementRounds, OfSchemesThatSplitLeaveThePictureAsItIs) {
  for (const RefineScheme scheme : {RefineScheme::kPrism, RefineScheme::kBisect}) {
    OptimizeOptions options = SmallRunOptions();
    options.refine = scheme;
    const ScratchFolder folder;
    SmallRun run(options);
    RefinementRounds rounds(
        run.options, {4, 2000},
        {run.field, run.motion, run.pictures, run.batches, run.steps, *run.renderer},
        folder / "best.bin");
    run.PutField(0.2);
    const size_t before = run.field.mesh().positions.size();
    rounds.Advance();
    EXPECT_GT(run.field.mesh().positions.size(), 1.1 * double(before));
    EXPECT_NEAR(run.pictures.JudgeField().psnr, rounds.state().best_psnr, 1e-3);
    CheckTetMesh(run.field.mesh());
    CheckConvexDomain(run.field.mesh());
  }
}

}  // namespace
}  // namespace tetrec
