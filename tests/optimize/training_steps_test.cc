#include "optimize/training_steps.h"

#include "optimize/small_run.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(TrainingSteps, ThatWereTriedAreTakenAgainWithTheSameResult) {
  SmallRun run;
  run.PutField(0.2);
  const FieldState before = run.field.ReadState();
  run.steps.Try(3, 0.1);
  const FieldState tried = run.field.ReadState();
  EXPECT_TRUE(tried.parameters != before.parameters);
  EXPECT_EQ(run.steps.iteration(), 0u);
  EXPECT_EQ(run.steps.rays(), 3u * 256u);

  run.field.PutState(before);
  for (int i = 0; i < 3; ++i) run.steps.Take(0.1, false);
  EXPECT_TRUE(run.field.ReadState().parameters == tried.parameters);
  EXPECT_TRUE(run.field.ReadState().second_moment == tried.second_moment);
  EXPECT_EQ(run.steps.iteration(), 3u);
}

TEST(TrainingSteps, AfterAResumeAreThoseThatWouldHaveFollowed) {
  SmallRun whole, resumed;
  whole.PutField(0.2);
  whole.steps.Take(0.1, false);
  whole.steps.Take(0.1, false);
  resumed.field.PutState(whole.field.ReadState());
  resumed.steps.Resume(whole.steps.iteration(), whole.steps.rays());
  for (SmallRun* run : {&whole, &resumed}) run->steps.Take(0.2, false);
  EXPECT_TRUE(resumed.field.ReadState().parameters == whole.field.ReadState().parameters);
  EXPECT_EQ(resumed.steps.rays(), 3u * 256u);
}

}  // namespace
}  // namespace tetrec
