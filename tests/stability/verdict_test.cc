// Verdicts of the stress test and of the sweep.
#include "stability/stress.h"
#include "stability/stress_report.h"
#include "stability/sweep.h"

#include <gtest/gtest.h>

#include <set>

namespace tetrec {
namespace {

ChainResult RunOf(double psnr) {
  ChainResult run;
  run.psnr = psnr;
  return run;
}

ChainResult Failure(int exit_code, const std::string& said) {
  ChainResult run;
  run.exit_code = exit_code;
  run.said = said;
  return run;
}

TEST(Verdict, HoldsUpToThreeDecibels) {
  const ChainResult twin = RunOf(30);
  EXPECT_EQ(Judge(RunOf(27), &twin, false), Verdict::kHolds);
  EXPECT_EQ(Judge(RunOf(26.9), &twin, false), Verdict::kBreaks);
  EXPECT_EQ(Judge(RunOf(26.9), &twin, true), Verdict::kExcused);
  EXPECT_EQ(Judge(RunOf(kLeastOfClean_db), nullptr, false), Verdict::kClean);
  EXPECT_EQ(Judge(RunOf(kLeastOfClean_db - 0.1), nullptr, false), Verdict::kBreaks);
}

TEST(Verdict, DistinguishesMessagesFromBugs) {
  const ChainResult twin = RunOf(30);
  EXPECT_EQ(Judge(Failure(3, "tetrec-optimize: too few points"), &twin, false), Verdict::kRefused);
  EXPECT_EQ(Judge(Failure(3, ""), &twin, false), Verdict::kBreaks);
  EXPECT_EQ(Judge(Failure(2, "tetrec-optimize: no such option"), &twin, false), Verdict::kBreaks);
  EXPECT_EQ(Judge(Failure(4, "tetrec-optimize: no device"), &twin, true), Verdict::kBreaks);
  EXPECT_EQ(Judge(Failure(3, "tetrec-optimize: no views"), nullptr, false), Verdict::kBreaks);
  EXPECT_EQ(Judge(Failure(1, "tetrec-optimize: bug"), &twin, false), Verdict::kBreaks);
  EXPECT_EQ(Judge(Failure(139, "Segmentation fault"), &twin, true), Verdict::kBreaks);
  EXPECT_EQ(Judge(Failure(kTookTooLong, "killed"), &twin, true), Verdict::kBreaks);
}

TEST(Verdict, BreaksByDegenerateTets) {
  const ChainResult twin = RunOf(30);
  ChainResult run = RunOf(31);
  run.degenerate_tets = 1;
  EXPECT_EQ(Judge(run, &twin, true), Verdict::kBreaks);
}

TEST(Verdict, IsNoneWithoutATwin) {
  const ChainResult twin = Failure(3, "no");
  EXPECT_EQ(Judge(RunOf(30), &twin, false), Verdict::kSkipped);
}

TEST(StressCases, HaveNamesOfTheirOwnAndTwinsBeforeThem) {
  std::set<std::string> names;
  for (const StressCase& stress : StressCases(400, 1)) {
    EXPECT_TRUE(names.insert(stress.name).second) << stress.name;
    EXPECT_TRUE(stress.twin.empty() || names.contains(stress.twin)) << stress.name;
    EXPECT_EQ(stress.name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789.-"),
              std::string::npos)
        << stress.name;
  }
  EXPECT_GT(names.size(), 20u);
}

TEST(StressSummary, CountsVerdicts) {
  std::vector<StressResult> results(3);
  results[0].verdict = Verdict::kClean;
  results[1].verdict = results[2].verdict = Verdict::kHolds;
  EXPECT_EQ(StressSummary(results), "clean: 1, holds: 2");
}

TEST(Sweep, ComparesSafeMotionWithFixedVerticesAtTheSameColourRate) {
  const auto result = [](SweptParameter parameter, SweptMethod method, double value, double psnr) {
    return SweepResult{parameter, method, value, RunOf(psnr)};
  };
  using P = SweptParameter;
  using M = SweptMethod;
  std::vector<SweepResult> results = {
      result(P::kColorRate, M::kFixed, 1, 20), result(P::kColorRate, M::kSafe, 1, 19.5),
      result(P::kPositionRate, M::kFixed, 0.1, 30), result(P::kPositionRate, M::kSafe, 0.1, 28),
      result(P::kPositionRate, M::kArticle, 0.1, 10)};
  std::vector<SweepResult> unsafe = UnsafeRuns(results);
  ASSERT_EQ(unsafe.size(), 1u);
  EXPECT_EQ(*unsafe[0].run.psnr, 28);
  results[1].run.degenerate_tets = 5;
  EXPECT_EQ(UnsafeRuns(results).size(), 2u);
}

}  // namespace
}  // namespace tetrec
