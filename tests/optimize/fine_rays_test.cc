#include "optimize/fine_rays.h"

#include "core/stop_request.h"
#include "optimize/small_run.h"

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>

namespace tetrec {
namespace {

OptimizeOptions WithChoice(FineRaysChoice choice) {
  OptimizeOptions options = SmallRunOptions();
  options.fine_rays = choice;
  return options;
}

struct FineRun : SmallRun {
  explicit FineRun(FineRaysChoice choice, bool has_alpha = true)
      : SmallRun(WithChoice(choice)), fine_rays(options, has_alpha, field, pictures, steps) {}
  // Whether a late step does what one with fine rays does.
  bool TakesFineRays() {
    const FieldState before = field.ReadState();
    steps.Take(AtProgress(0.9), false);
    const FieldState taken = field.ReadState();
    const uint64_t rays = steps.rays() / 2;
    field.PutState(before);
    steps.Resume(steps.iteration() - 1, rays);
    steps.UseFineRays(true);
    steps.Take(AtProgress(0.9), false);
    const bool fine = taken.parameters == field.ReadState().parameters;
    fine_rays.Resume(fine_rays.state());
    return fine;
  }
  FineRays fine_rays;
};

TEST(FineRays, AreTakenOrNotAsChosen) {
  for (const bool has_alpha : {false, true}) {
    FineRun on(FineRaysChoice::kOn, has_alpha), off(FineRaysChoice::kOff, has_alpha);
    for (FineRun* run : {&on, &off}) {
      run->PutField(0.2);
      EXPECT_FALSE(run->fine_rays.Advance(0.69));
    }
    EXPECT_EQ(on.fine_rays.state(), TrialState::kUsed);
    EXPECT_EQ(off.fine_rays.state(), TrialState::kNotUsed);
    EXPECT_TRUE(on.TakesFineRays());
    EXPECT_FALSE(off.TakesFineRays());
  }
}

// The field stays as it was, or as 2 x 2 rays made it if they are taken. Near the truth they are.
TEST(FineRays, AreTriedOnceTheRunHasGrown) {
  for (const bool fine : {false, true}) {
    FineRun run(FineRaysChoice::kAuto);
    run.PutField(fine ? 0.42 : 0.2);
    run.steps.Resume(1760, 0);
    EXPECT_FALSE(run.fine_rays.Advance(0.5));
    EXPECT_EQ(run.fine_rays.state(), TrialState::kNotTried);
    const FieldState before = run.field.ReadState();
    EXPECT_TRUE(run.fine_rays.Advance(0.69));
    ASSERT_TRUE(run.fine_rays.trial());
    const auto [one, four] = *run.fine_rays.trial();
    EXPECT_NE(one, four);
    EXPECT_EQ(run.fine_rays.trial()->PrefersFour(), fine);
    EXPECT_EQ(run.fine_rays.state(), fine ? TrialState::kUsed : TrialState::kNotUsed);
    EXPECT_EQ(run.field.ReadState().parameters != before.parameters, fine);
    EXPECT_EQ(run.field.ReadState().second_moment != before.second_moment, fine);
    EXPECT_EQ(run.steps.iteration(), fine ? 1870u : 1760u);
    EXPECT_EQ(run.TakesFineRays(), fine);
    EXPECT_FALSE(run.fine_rays.Advance(0.69));
  }
}

TEST(FineRays, AreNotTriedForPhotosWithoutAlpha) {
  FineRun run(FineRaysChoice::kAuto, /*has_alpha=*/false);
  run.PutField(0.2);
  run.steps.Resume(1760, 0);
  EXPECT_EQ(run.fine_rays.state(), TrialState::kNotUsed);
  EXPECT_FALSE(run.fine_rays.Advance(0.69));
  EXPECT_FALSE(run.fine_rays.trial());
  EXPECT_FALSE(run.TakesFineRays());
}

TEST(FineRays, AreTriedLaterIfTheRunIsStoppedMeanwhile) {
  const auto stopped = [] {
    CatchStopSignals();
    FineRun run(FineRaysChoice::kAuto);
    run.PutField(0.2);
    run.steps.Resume(1100, 7);
    const FieldState before = run.field.ReadState();
    std::raise(SIGINT);
    const bool is_held = run.fine_rays.Advance(0.69);
    const bool is_as_before = run.fine_rays.state() == TrialState::kNotTried &&
                              run.field.ReadState().parameters == before.parameters &&
                              run.steps.iteration() == 1100 && run.steps.rays() == 7;
    std::exit(!is_held && is_as_before ? 0 : 1);
  };
  EXPECT_EXIT(stopped(), ::testing::ExitedWithCode(0), "");
}

TEST(FineRays, JudgeTheFieldsThatTheyMake) {
  FineRun run(FineRaysChoice::kAuto);
  run.PutField(0.2);
  const double by_one = run.pictures.JudgeField(1).psnr, by_four = run.pictures.JudgeField(2).psnr;
  ASSERT_NE(by_one, by_four);
  run.fine_rays.Resume(TrialState::kUsed);
  EXPECT_EQ(run.pictures.JudgeField().psnr, by_four);
  run.fine_rays.Resume(TrialState::kNotUsed);
  EXPECT_EQ(run.pictures.JudgeField().psnr, by_one);
}

TEST(FineRays, AreTakenUnlessTheyLoseClearly) {
  const auto prefers_four = [](double gain) {
    return FineRaysTrial{.one_psnr = 30.0, .four_psnr = 30.0 + gain}.PrefersFour();
  };
  EXPECT_TRUE(prefers_four(0.1));
  EXPECT_TRUE(prefers_four(-0.06));
  EXPECT_FALSE(prefers_four(-0.12));
}

TEST(FineRays, AreNotTriedInShortRuns) {
  FineRun run(FineRaysChoice::kAuto);
  run.steps.Resume(999, 0);
  EXPECT_FALSE(run.fine_rays.Advance(0.69));
  EXPECT_EQ(run.fine_rays.state(), TrialState::kNotUsed);
}

TEST(FineRays, AreNotTakenWhereNothingCanJudge) {
  FineRun run(FineRaysChoice::kAuto);
  run.steps.Resume(1100, 0);
  run.pictures.EndJudgingIfDue(1.0);
  EXPECT_FALSE(run.fine_rays.Advance(1.0));
  EXPECT_EQ(run.fine_rays.state(), TrialState::kNotUsed);
}

TEST(FineRays, ContinueAsTheyWereDecided) {
  for (const TrialState state : {TrialState::kUsed, TrialState::kNotUsed}) {
    FineRun run(FineRaysChoice::kAuto);
    run.PutField(0.2);
    run.fine_rays.Resume(state);
    EXPECT_FALSE(run.fine_rays.Advance(0.69));
    EXPECT_EQ(run.fine_rays.state(), state);
    EXPECT_EQ(run.TakesFineRays(), state == TrialState::kUsed);
  }
}

}  // namespace
}  // namespace tetrec
