// Rates that spoil the start are found before the run.
#include "optimize/rate_trial.h"

#include "core/log.h"
#include "optimize/small_run.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

OptimizeOptions WithRates(double factor) {
  OptimizeOptions options = SmallRunOptions();
  const FirstRates usual = FirstRatesOf(options, false);
  options.color_rate = factor * usual.color;
  options.density_rate = factor * usual.density;
  return options;
}

// A start that is almost right.
struct RateTrialRun : SmallRun {
  explicit RateTrialRun(const OptimizeOptions& run_options) : SmallRun(run_options) {
    PutField(0.3);
    TakeWarnings();
  }
  RateTrial trial{options, field, pictures, steps};
};

TEST(RateTrial, LeavesRatesThatGain) {
  RateTrialRun run(WithRates(1));
  const double start = run.pictures.JudgeField().psnr;
  EXPECT_TRUE(run.trial.Advance());
  EXPECT_EQ(run.steps.share_of_rates(), 1);
  EXPECT_EQ(run.steps.iteration(), 20u);
  EXPECT_GT(run.pictures.JudgeField().psnr, start);
  EXPECT_TRUE(TakeWarnings().empty());
  EXPECT_FALSE(run.trial.Advance());
}

TEST(RateTrial, DividesRatesThatSpoilTheStart) {
  for (const double factor : {100.0, 10'000.0}) {
    RateTrialRun run(WithRates(factor));
    const double start = run.pictures.JudgeField().psnr;
    EXPECT_TRUE(run.trial.Advance());
    EXPECT_LE(run.steps.share_of_rates(), 0.11) << factor;
    EXPECT_GE(run.steps.share_of_rates() * factor, 0.09) << "no lower than needed";
    EXPECT_GT(run.pictures.JudgeField().psnr, start - 0.1) << factor;
    EXPECT_EQ(run.steps.iteration(), 20u);
    const std::vector<std::string> warnings = TakeWarnings();
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_NE(warnings[0].find("rates are too high"), std::string::npos) << warnings[0];
  }
}

TEST(RateTrial, GoesOnAsARunWithTheLowerRates) {
  RateTrialRun high(WithRates(100));
  high.trial.Advance();
  RateTrialRun low(WithRates(100 * high.steps.share_of_rates()));
  low.steps.Try(20, AtProgress(0));
  const std::vector<float> expected = low.field.ReadState().parameters;
  const std::vector<float> found = high.field.ReadState().parameters;
  ASSERT_EQ(found.size(), expected.size());
  for (size_t i = 0; i < found.size(); ++i) ASSERT_NEAR(found[i], expected[i], 1e-5) << i;
}

TEST(RateTrial, IsNotHeldLaterOrWhereItWouldTakeTooMuchOfTheRun) {
  RateTrialRun begun(WithRates(1000));
  begun.steps.CountTried(1);
  EXPECT_FALSE(begun.trial.Advance());
  OptimizeOptions brief = WithRates(1000);
  brief.iterations = 59;
  RateTrialRun run(brief);
  EXPECT_FALSE(run.trial.Advance());
  EXPECT_EQ(run.steps.share_of_rates(), 1);
}

TEST(RateTrial, IsNotHeldWhereNothingJudges) {
  RateTrialRun run(WithRates(1000));
  run.pictures.EndJudgingIfDue(1.0);
  EXPECT_FALSE(run.trial.Advance());
}

}  // namespace
}  // namespace tetrec
