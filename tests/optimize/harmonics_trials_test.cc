#include "optimize/harmonics_trials.h"

#include "core/stop_request.h"
#include "optimize/small_run.h"
#include "render/seen_colors.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

namespace tetrec {
namespace {

OptimizeOptions WithChoice(HarmonicsChoice choice) {
  OptimizeOptions options = SmallRunOptions();
  options.harmonics = choice;
  return options;
}

struct HarmonicsTrialRun : SmallRun {
  explicit HarmonicsTrialRun(HarmonicsChoice choice, const RadianceField& truth = WavyBox(0.4),
                             size_t photos = 9)  // as many as degree 2 needs
      : SmallRun(WithChoice(choice), photos, truth) {}
  HarmonicsTrials trials{options, field, pictures, steps};
};

TEST(HarmonicsTrials, UnlockTheChosenDegreeAndNoMore) {
  HarmonicsTrialRun run(HarmonicsChoice::kDegree1);
  EXPECT_FALSE(run.trials.Advance(0.0));
  EXPECT_EQ(run.field.harmonics_degree(), 0);
  EXPECT_TRUE(run.trials.Advance(0.5));
  EXPECT_EQ(run.field.harmonics_degree(), 1);
  EXPECT_TRUE(run.batches.few_views());
  EXPECT_FALSE(run.trials.Advance(1.0));
}

// The photos show colours that do not depend on the view.
TEST(HarmonicsTrials, DropADegreeThatGainsNothing) {
  HarmonicsTrialRun run(HarmonicsChoice::kAuto);
  run.steps.CountTried(kFewestTrialSteps);
  ASSERT_TRUE(run.trials.Advance(0.2));
  EXPECT_EQ(run.field.harmonics_degree(), 1);
  ASSERT_TRUE(run.trials.Advance(0.5));
  EXPECT_EQ(run.field.harmonics_degree(), 0);
  EXPECT_EQ(run.steps.iteration(), kFewestTrialSteps);
  EXPECT_EQ(run.steps.rays(), 2 * kFewestTrialSteps * 256);
  EXPECT_EQ(run.trials.state(), (HarmonicsState{.unlocked = 1, .judged = 1, .closed = 1}));
  EXPECT_FALSE(run.trials.Advance(1.0));
}

// A box that is lighter from one side.
RadianceField BoxThatFollowsTheView() {
  RadianceField box = WavyBox(0.2);
  AttributeValues harmonics{HarmonicsAttribute(1), {}};
  for (size_t i = 0; i < box.mesh.positions.size(); ++i) {
    harmonics.values.insert(harmonics.values.end(), {0, 0, 0, 0, 0, 0, 0.3f, 0.3f, 0.3f});
  }
  box.others = {std::move(harmonics)};
  return box;
}

TEST(HarmonicsTrials, KeepADegreeThatIsMissedAtOnceWithoutTraining) {
  RadianceField box = BoxThatFollowsTheView();
  HarmonicsTrialRun run(HarmonicsChoice::kAuto, box);
  run.steps.CountTried(kFewestTrialSteps);
  ASSERT_TRUE(run.trials.Advance(0.2));
  const FieldState state = StateOf(box);
  run.field.Put(std::move(box.mesh), state);
  const uint64_t rays = run.steps.rays();
  ASSERT_TRUE(run.trials.Advance(0.3));
  EXPECT_EQ(run.trials.state(), (HarmonicsState{.unlocked = 1, .judged = 1}));
  EXPECT_EQ(run.steps.rays(), rays);
  EXPECT_EQ(run.field.ReadState().parameters, state.parameters);
}

TEST(HarmonicsTrials, AreHeldLaterIfTheRunIsStoppedMeanwhile) {
  const auto stopped = [] {
    CatchStopSignals();
    HarmonicsTrialRun run(HarmonicsChoice::kAuto);
    run.steps.Resume(kFewestTrialSteps, 7);
    run.trials.Advance(0.2);
    const FieldState before = run.field.ReadState();
    const HarmonicsState state = run.trials.state();
    std::raise(SIGINT);
    const bool is_held = run.trials.Advance(0.5);
    const bool is_as_before = run.trials.state() == state && run.field.harmonics_degree() == 1 &&
                              run.field.ReadState().parameters == before.parameters &&
                              run.steps.iteration() == kFewestTrialSteps && run.steps.rays() == 7;
    std::exit(!is_held && is_as_before ? 0 : 1);
  };
  EXPECT_EXIT(stopped(), ::testing::ExitedWithCode(0), "");
}

TEST(HarmonicsTrials, UnlockNothingWhereNothingCanJudge) {
  HarmonicsTrialRun run(HarmonicsChoice::kAuto);
  run.steps.CountTried(kFewestTrialSteps);
  run.pictures.EndJudgingIfDue(1.0);
  EXPECT_TRUE(run.trials.Advance(1.0));
  EXPECT_EQ(run.field.harmonics_degree(), 0);
  EXPECT_FALSE(run.trials.Advance(1.0));
}

// Only degrees that are judged need pictures that judge, and none has more functions than there are
// photos.
TEST(HarmonicsTrials, UnlockTheRestAfterTheJudgingPictures) {
  HarmonicsTrialRun run(HarmonicsChoice::kAuto);
  run.steps.CountTried(kFewestTrialSteps);
  ASSERT_TRUE(run.trials.Advance(0.2));
  run.pictures.EndJudgingIfDue(1.0);
  ASSERT_TRUE(run.trials.Advance(0.3));  // too late to judge: it stays
  ASSERT_TRUE(run.trials.Advance(0.4));
  EXPECT_EQ(run.trials.state(), (HarmonicsState{.unlocked = 1, .judged = 1, .closed = 1}));

  run.trials.Resume({.unlocked = 2, .judged = 2});
  EXPECT_FALSE(run.trials.Advance(1.0));
  HarmonicsTrialRun many(HarmonicsChoice::kAuto, WavyBox(0.4), 16);
  many.field.PutState(WithHarmonics(many.field.ReadState(), 2));
  many.trials.Resume({.unlocked = 2, .judged = 2});
  many.pictures.EndJudgingIfDue(1.0);
  EXPECT_TRUE(many.trials.Advance(1.0));
  EXPECT_EQ(many.field.harmonics_degree(), 3);
}

// The trial would be longer than the run.
TEST(HarmonicsTrials, UnlockNothingInARunOfFewSteps) {
  HarmonicsTrialRun run(HarmonicsChoice::kAuto);
  run.steps.CountTried(kFewestTrialSteps - 1);
  EXPECT_TRUE(run.trials.Advance(0.5));
  EXPECT_EQ(run.field.harmonics_degree(), 0);
  EXPECT_EQ(run.trials.state(), (HarmonicsState{.closed = 1}));
}

}  // namespace
}  // namespace tetrec
