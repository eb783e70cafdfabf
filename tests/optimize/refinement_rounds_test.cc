#include "optimize/refinement_rounds.h"

#include "core/random.h"
#include "core/stop_request.h"
#include "optimize/small_run.h"
#include "sanitized.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <vector>

namespace tetrec {
namespace {

RoundsFiles FilesIn(const std::filesystem::path& folder) {
  return {folder / "best.bin", folder / "unrefined.bin", folder / "coarser.bin",
          folder / "finer.bin"};
}

class RefinementRoundsTest : public ::testing::Test {
 protected:
  const ScratchFolder folder_;
  SmallRun run_;
  const std::vector<PlannedRound> plan_{{0.1, 1000}, {0.2, 1300}, {0.5, 1600}, {1.2, 2000, true}};
  RefinementRounds rounds_{
      run_.options,
      plan_,
      {run_.field, run_.motion, run_.pictures, run_.batches, run_.steps, *run_.renderer},
      FilesIn(folder_.path())};
  size_t vertices() const { return run_.field.mesh().positions.size(); }
};

TEST_F(RefinementRoundsTest, AreDueOneAfterAnother) {
  for (uint32_t round = 0; round < plan_.size(); ++round) {
    EXPECT_FALSE(rounds_.IsDue(plan_[round].due - 1e-3));
    ASSERT_TRUE(rounds_.IsDue(plan_[round].due));
    rounds_.Resume({.rounds = round + 1});
  }
  EXPECT_FALSE(rounds_.IsDue(2.0));
}

TEST_F(RefinementRoundsTest, GoOnWithAFieldThatGained) {
  run_.PutField(0.2);
  rounds_.Advance(0.0, AtProgress(0.5));
  const double first = rounds_.state().best_psnr;
  const size_t refined = vertices();
  EXPECT_GT(refined, WavyBox(0.2).mesh.positions.size());
  run_.PutField(0.4);
  rounds_.Advance(0.0, AtProgress(0.5));
  EXPECT_EQ(rounds_.state().rounds, 2u);
  EXPECT_GT(rounds_.state().best_psnr, first);
}

TEST_F(RefinementRoundsTest, EndLateWhereTheJudgingPicturesGainNothing) {
  float density = 0.2f;
  for (uint32_t round = 1; round <= 3; ++round) {
    run_.PutField(density += 0.05f);
    rounds_.Advance(0.0, AtProgress(0.5));
    ASSERT_EQ(rounds_.state().rounds, round);
  }
  run_.PutField(density);
  const size_t before = vertices();
  ASSERT_TRUE(rounds_.IsDue(1.2));
  rounds_.Advance(0.0, AtProgress(0.5));
  EXPECT_EQ(vertices(), before);
  EXPECT_EQ(rounds_.state().rounds, 3u);
  EXPECT_FALSE(rounds_.IsDue(2.0));
  EXPECT_TRUE(rounds_.IsOver());
  const std::vector<GrowthStep>& steps = rounds_.state().steps;
  ASSERT_EQ(steps.size(), 4u);
  EXPECT_EQ(steps[2].decision, GrowthDecision::kRefine);
  EXPECT_EQ(steps[3].decision, GrowthDecision::kFineEnough);
  EXPECT_EQ(steps[3].vertices, before);
  EXPECT_GT(steps[3].psnr, 0.0);
}

// Noise of high learning rates is no reason to refine no more.
TEST_F(RefinementRoundsTest, ContinueWhereALossIsWithinItsStandardError) {
  const Judgement now = run_.pictures.JudgeField();
  std::vector<ErrorSum> before = now.views;
  for (size_t i = 0; i < before.size(); ++i) before[i].squares *= i % 2 == 0 ? 2.0 : 0.5;
  ASSERT_GT(GainBetween(before, now.views).standard_error, 0.3);
  rounds_.Resume({.rounds = 1, .best_psnr = now.psnr + 0.25, .last_views = before});
  rounds_.Advance(0.0, AtProgress(0.5));
  EXPECT_EQ(rounds_.state().steps.back().decision, GrowthDecision::kRefine);
}

TEST_F(RefinementRoundsTest, EndEarlyOnceTwoInARowGainNothing) {
  for (uint32_t round = 1; round <= 2; ++round) {
    run_.PutField(0.3);
    rounds_.Advance(0.0, AtProgress(0.5));
    ASSERT_EQ(rounds_.state().rounds, round);
  }
  run_.PutField(0.3);
  const size_t before = vertices();
  rounds_.Advance(0.0, AtProgress(0.5));
  EXPECT_EQ(vertices(), before);
  EXPECT_TRUE(rounds_.IsOver());
  EXPECT_EQ(rounds_.state().steps.back().decision, GrowthDecision::kFineEnough);
}

TEST_F(RefinementRoundsTest, EndOnceTheJudgingPicturesAreMatched) {
  const size_t before = vertices();
  const Judgement judgement = run_.pictures.JudgeField();
  run_.options.schedule.matched_psnr = judgement.psnr - judgement.standard_error - 0.01;
  rounds_.Advance(0.0, AtProgress(0.5));
  EXPECT_EQ(vertices(), before);
  EXPECT_TRUE(rounds_.IsOver());
  EXPECT_EQ(rounds_.state().steps.back().decision, GrowthDecision::kMatched);
}

// Else the noise of high rates, which the judgement before was spared, would look like a loss.
TEST_F(RefinementRoundsTest, SettleTheFieldFirstOnceAJudgementHasSettled) {
  run_.PutField(0.2);
  const double psnr = run_.pictures.JudgeField().psnr;
  run_.options.schedule.matched_psnr = psnr + 5.03;
  rounds_.Resume({.rounds = 1, .best_psnr = psnr + 0.05});
  const uint64_t before = run_.steps.iteration();
  rounds_.Advance(0.0, AtProgress(0.5));
  const uint64_t settled = run_.steps.iteration();
  EXPECT_GT(settled, before);
  EXPECT_TRUE(run_.motion.CanResumeAfter(settled, 0.5));
  EXPECT_EQ(rounds_.state().settled, settled);
  EXPECT_TRUE(rounds_.state().steps.empty());
  EXPECT_TRUE(rounds_.IsDue(0.2));
  rounds_.Advance(0.0, AtProgress(0.5));
  EXPECT_EQ(run_.steps.iteration(), settled);
  EXPECT_EQ(rounds_.state().steps.size(), 1u);
}

// A judgement by other rays would look like a gain or a loss of the round.
TEST_F(RefinementRoundsTest, CompareWithTheFieldThatWasJudgedAnew) {
  rounds_.Advance(0.0, AtProgress(0.5));
  ASSERT_EQ(rounds_.state().rounds, 1u);
  run_.PutField(0.5);
  run_.pictures.JudgeBy(2);
  const Judgement anew = run_.pictures.JudgeField();
  rounds_.JudgeAnew(anew);
  EXPECT_EQ(rounds_.state().best_psnr, anew.psnr);
  const std::vector<float> best = run_.field.ReadState().parameters;
  run_.PutField(0.2);
  ASSERT_LT(run_.pictures.JudgeField().psnr, anew.psnr - 1);
  rounds_.Advance(0.0, AtProgress(0.5));
  EXPECT_EQ(rounds_.state().steps.back().decision, GrowthDecision::kReturn);
  EXPECT_LT(rounds_.state().steps.back().gain, -1);
  EXPECT_EQ(run_.field.ReadState().parameters, best);
}

TEST_F(RefinementRoundsTest, ContinueWhereThePicturesAreMatchedIfTheOptionsAskForAll) {
  run_.options.schedule.matched_psnr = 1;
  run_.options.budget = BudgetChoice::kFull;
  const size_t before = vertices();
  rounds_.Advance(0.0, AtProgress(0.5));
  EXPECT_GT(vertices(), before);
}

TEST_F(RefinementRoundsTest, AreAllDoneWhereTheOptionsAskForThem) {
  for (const bool is_full : {true, false}) {
    OptimizeOptions options = SmallRunOptions();
    if (is_full) {
      options.budget = BudgetChoice::kFull;
    } else {
      options.schedule.rounds = 4;
    }
    const ScratchFolder folder;
    SmallRun run(options);
    RefinementRounds rounds(
        run.options, plan_,
        {run.field, run.motion, run.pictures, run.batches, run.steps, *run.renderer},
        FilesIn(folder.path()));
    for (uint32_t round = 1; round <= plan_.size(); ++round) {
      run.PutField(0.3);
      rounds.Advance(0.0, AtProgress(0.5));
      EXPECT_EQ(rounds.state().rounds, round);
    }
  }
}

// Bounds between the first mesh and what the plan asks for, and just above the first mesh.
TEST_F(RefinementRoundsTest, NeverExceedTheBudget) {
  for (const RefineScheme scheme :
       {RefineScheme::kInsert, RefineScheme::kHalve, RefineScheme::kPrism, RefineScheme::kBisect}) {
    for (const double share : {1.0, 1.001, 1.3}) {
      if (kIsSanitized && share != 1.001) continue;
      OptimizeOptions options = SmallRunOptions();
      options.refine = scheme;
      options.budget = BudgetChoice::kFull;
      const ScratchFolder folder;
      SmallRun run(options);
      run.PutField(0.2);
      const uint64_t bound = uint64_t(share * double(run.field.mesh().tets.size()));
      RefinementRounds rounds(
          run.options, {{0.1, 2000}, {0.2, 4000}},
          {run.field, run.motion, run.pictures, run.batches, run.steps, *run.renderer},
          FilesIn(folder.path()), bound);
      while (!rounds.IsOver()) {
        rounds.Advance(0.0, AtProgress(0.5));
        EXPECT_LE(run.field.mesh().tets.size(), bound);
        CheckTetMesh(run.field.mesh());
      }
    }
  }
}

TEST_F(RefinementRoundsTest, TakeBackAFieldThatLost) {
  run_.steps.Take(AtProgress(0.0), false);  // so that there are moments
  const std::vector<glm::vec3> positions = run_.field.mesh().positions;
  const FieldState best = run_.field.ReadState();
  rounds_.Advance(0.0, AtProgress(0.5));
  ASSERT_GT(vertices(), positions.size());
  FieldState worse = run_.field.ReadState();
  for (float& parameter : worse.parameters) parameter = 0.0f;
  run_.field.PutState(worse);
  rounds_.Advance(0.0, AtProgress(0.5));
  const FieldState now = run_.field.ReadState();
  EXPECT_TRUE(run_.field.mesh().positions == positions);
  EXPECT_TRUE(now.parameters == best.parameters);
  EXPECT_TRUE(now.second_moment == best.second_moment);
  EXPECT_FALSE(rounds_.IsDue(2.0));
}

// The box is opaque: rays lose their light near its sides.
TEST_F(RefinementRoundsTest, DropWhatNoRaySeesAndRecordIt) {
  run_.PutField(0.2);
  const size_t tets = run_.field.mesh().tets.size();
  rounds_.Advance(0.0, AtProgress(0.5));
  const GrowthStep& step = rounds_.state().steps.back();
  EXPECT_GT(step.empty_tets, tets / 10);
  EXPECT_LT(step.empty_tets, tets);
  CheckTetMesh(run_.field.mesh());
  CheckConvexDomain(run_.field.mesh());
}

TEST_F(RefinementRoundsTest, TakeNothingBackWhereNothingJudges) {
  run_.pictures.EndJudgingIfDue(1.0);
  rounds_.Advance(0.0, AtProgress(0.5));
  run_.PutField(0.0);
  rounds_.Advance(0.0, AtProgress(0.5));
  EXPECT_EQ(rounds_.state().rounds, 2u);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "best.bin"));
}

// On a slow machine, so few steps are made that a round may come when the run is nearly over.
TEST_F(RefinementRoundsTest, AreLeftOutOnceTooLittleOfTheRunIsLeft) {
  const size_t before = vertices();
  rounds_.Advance(0.0, AtProgress(run_.options.schedule.last_judging));
  EXPECT_EQ(vertices(), before);
  EXPECT_TRUE(rounds_.IsOver());
  EXPECT_EQ(rounds_.state().steps.back().decision, GrowthDecision::kTooLate);
}

TEST_F(RefinementRoundsTest, ComeLateWhereAllAreWantedOrTheLastOneIsLate) {
  run_.options.schedule.last_round = 0.9;
  run_.PutField(0.2);
  rounds_.Advance(0.0, AtProgress(0.8));
  EXPECT_EQ(rounds_.state().rounds, 1u);
  run_.options.budget = BudgetChoice::kFull;
  run_.PutField(0.4);
  rounds_.Advance(0.0, AtProgress(0.95));
  EXPECT_EQ(rounds_.state().rounds, 2u);
}

TEST(RefinementRounds, LeaveTheFieldAsItIsIfNoRefinedMeshFitsTheBudget) {
  const ScratchFolder folder;
  SmallRun run;
  run.PutField(0.2);
  run.motion.StartIfDue(1.0);
  run.steps.Try(64, AtProgress(0.1), AtProgress(0.1));
  const FieldState field = run.field.ReadState();
  const MotionState motion = run.motion.state();
  RefinementRounds rounds(
      run.options, {{0.1, 2000}},
      {run.field, run.motion, run.pictures, run.batches, run.steps, *run.renderer},
      FilesIn(folder.path()), 10);
  rounds.Advance(0.0, AtProgress(0.5));
  EXPECT_EQ(rounds.state().steps.back().decision, GrowthDecision::kBudget);
  EXPECT_TRUE(run.field.ReadState().parameters == field.parameters);
  EXPECT_TRUE(run.motion.state().first_moment == motion.first_moment);
}

// A run after its first round.
struct RefinedRun {
  explicit RefinedRun(const OptimizeOptions& options, bool has_moved = false, bool is_late = false)
      : run(options),
        rounds(run.options, {{0.1, 2000, is_late}},
               {run.field, run.motion, run.pictures, run.batches, run.steps, *run.renderer},
               FilesIn(folder.path())) {
    run.PutField(0.2);
    if (has_moved) MoveVertices();
    const std::vector<glm::vec3> before = run.field.mesh().positions;
    rounds.Advance(0.0, AtProgress(0.5));
    EXPECT_FALSE(run.field.mesh().positions == before);
    CheckTetMesh(run.field.mesh());
  }

  // Until the mesh is far from a Delaunay mesh.
  void MoveVertices() {
    Random random(6);
    std::vector<glm::vec3> moves;
    for (const float room : run.field.RoomOfVertices()) {
      glm::vec3 move;
      for (int k = 0; k < 3; ++k) move[k] = 0.2f * (float(random.Uniform()) - 0.5f);
      moves.push_back(room > 0.2f ? move : glm::vec3(0.0f));
    }
    for (int i = 0; i < 5; ++i) run.field.MoveVertices(moves);
  }

  // Of the judging pictures, by the round [dB].
  double Change() { return std::abs(run.pictures.JudgeField().psnr - rounds.state().best_psnr); }

  ScratchFolder folder;
  SmallRun run;
  RefinementRounds rounds;
};

// Vertices that have moved are no longer those of a Delaunay mesh, so that a new triangulation
// changes tets everywhere.
TEST(RefinementRounds, LateOnesTriangulateNothingAnew) {
  OptimizeOptions options = SmallRunOptions();
  options.budget = BudgetChoice::kFull;  // without a trial, which would teach
  const double early = RefinedRun(options, true, false).Change();
  EXPECT_GT(early, 0.05);
  EXPECT_LT(RefinedRun(options, true, true).Change(), 0.5 * early);
}

// Before a late round, on a mesh of `side` vertices a side, of which photos show 9. Many views
// judge, so that the standard error is small.
struct LateRun {
  explicit LateRun(int side)
      : run(Options(), 20),
        rounds(run.options, {{1.2, 2 * uint64_t(side * side * side), true}},
               {run.field, run.motion, run.pictures, run.batches, run.steps, *run.renderer},
               FilesIn(folder.path())) {
    run.PutField(0.4, side);
    run.motion.StartIfDue(1.0);
    run.steps.Resume(kStepsBefore, 1000);
  }
  static OptimizeOptions Options() {
    OptimizeOptions options = SmallRunOptions();
    options.rays_per_step = 256;
    return options;
  }
  void Advance() { rounds.Advance(7.0, {0.3, 1.2}); }
  size_t vertices() const { return run.field.mesh().positions.size(); }

  // An eighth of the first, up to the next motion.
  static constexpr uint64_t kStepsBefore = 960, kStepsOfTrial = 128;
  ScratchFolder folder;
  SmallRun run;
  RefinementRounds rounds;
};

TEST(LateRound, StaysWhereTheFinerMeshLearnsMore) {
  LateRun late(5);
  late.Advance();
  EXPECT_GT(late.vertices(), 125u);
  EXPECT_EQ(late.rounds.state().rounds, 1u);
  EXPECT_EQ(late.rounds.state().ended, 0u);
  EXPECT_EQ(late.run.steps.iteration(), LateRun::kStepsBefore + LateRun::kStepsOfTrial);
  ASSERT_EQ(late.rounds.state().steps.size(), 1u);
  EXPECT_EQ(late.rounds.state().steps[0].decision, GrowthDecision::kRefine);
  EXPECT_EQ(late.rounds.state().steps[0].vertices, 125u);
}

// The mesh of the photos has nothing left to gain.
TEST(LateRound, IsTakenBackWhereTheFinerMeshLearnsNoMore) {
  LateRun late(9);
  const size_t before = late.vertices();
  const double psnr = late.run.pictures.JudgeField().psnr;
  late.Advance();
  EXPECT_EQ(late.vertices(), before);
  EXPECT_TRUE(late.rounds.IsOver());
  EXPECT_EQ(late.rounds.state().rounds, 0u);
  EXPECT_EQ(late.run.steps.iteration(), LateRun::kStepsBefore + LateRun::kStepsOfTrial);
  EXPECT_NE(late.run.pictures.JudgeField().psnr, psnr);  // it has learned
  const std::vector<GrowthStep>& steps = late.rounds.state().steps;
  ASSERT_EQ(steps.size(), 2u);
  EXPECT_EQ(steps[0].decision, GrowthDecision::kRefine);
  EXPECT_EQ(steps[1].decision, GrowthDecision::kTooFine);
  EXPECT_EQ(steps[1].seconds, 7.0);
  EXPECT_GT(steps[1].vertices, before);
  EXPECT_LE(steps[1].gain, steps[1].gain_standard_error);
  CheckTetMesh(late.run.field.mesh());
}

TEST(LateRound, IsUndoneByAStop) {
  const auto stopped = [] {
    CatchStopSignals();
    LateRun late(5);
    const std::vector<float> before = late.run.field.ReadState().parameters;
    std::raise(SIGINT);
    late.Advance();
    const bool is_as_before = late.run.field.ReadState().parameters == before &&
                              late.vertices() == 125 &&
                              late.run.steps.iteration() == LateRun::kStepsBefore &&
                              late.rounds.state() == RoundsState{} && late.rounds.IsDue(1.2);
    std::exit(is_as_before ? 0 : 1);
  };
  EXPECT_EXIT(stopped(), ::testing::ExitedWithCode(0), "");
}

// A resumed run must not settle the field once more.
TEST(LateRound, KeepsWhatHasSettledThroughAStop) {
  const auto stopped = [] {
    CatchStopSignals();
    LateRun late(5);
    late.run.options.schedule.matched_psnr = late.run.pictures.JudgeField().psnr + 3;
    late.Advance();
    const RoundsState settled = late.rounds.state();
    const std::vector<float> parameters = late.run.field.ReadState().parameters;
    std::raise(SIGINT);
    late.Advance();
    const bool is_as_before = settled.settled > LateRun::kStepsBefore &&
                              late.rounds.state() == settled &&
                              late.run.steps.iteration() == settled.settled &&
                              late.run.field.ReadState().parameters == parameters;
    std::exit(is_as_before ? 0 : 1);
  };
  EXPECT_EXIT(stopped(), ::testing::ExitedWithCode(0), "");
}

// The picture of the judging views does not change by a split, so it does not change by a round.
TEST(RefinementRounds, OfSchemesThatSplitLeaveThePictureAsItIs) {
  for (const RefineScheme scheme : {RefineScheme::kPrism, RefineScheme::kBisect}) {
    OptimizeOptions options = SmallRunOptions();
    options.refine = scheme;
    RefinedRun refined(options);
    EXPECT_LT(refined.Change(), 1e-3);
    EXPECT_GT(refined.run.field.mesh().positions.size(), 1000u);  // from 729
    CheckConvexDomain(refined.run.field.mesh());
  }
}

}  // namespace
}  // namespace tetrec
