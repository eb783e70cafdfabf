#include "eval/growth_plot.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

GrowthStep Judged(uint64_t tets, double psnr, double standard_error) {
  GrowthStep step;
  step.tets = tets;
  step.psnr = psnr;
  step.gain_standard_error = standard_error;
  return step;
}

TEST(GrowthPlot, ShowsWhatWasJudgedAndMarksTheSizeOfTheResult) {
  const GrowthStep unjudged = Judged(3000, 0, 0), result = Judged(4000, 0, 0);
  const std::optional<Plot> plot =
      GrowthPlot({{"", {Judged(1000, 20, 0), Judged(2000, 25, 0.5), unjudged, result}}});
  ASSERT_TRUE(plot);
  ASSERT_EQ(plot->series.size(), 4u);
  EXPECT_EQ(plot->series[0].x, (std::vector<double>{1000, 2000}));
  EXPECT_EQ(plot->series[0].y, (std::vector<double>{20, 25}));
  EXPECT_EQ(plot->series[1].y, (std::vector<double>{20, 24.5}));
  EXPECT_EQ(plot->series[2].y, (std::vector<double>{20, 25.5}));
  EXPECT_EQ(plot->series[3].x, (std::vector<double>{4000, 4000}));
  EXPECT_EQ(plot->series[3].y, (std::vector<double>{20, 25.5}));
}

TEST(GrowthPlot, NeedsTwoJudgedMeshes) {
  EXPECT_FALSE(GrowthPlot({}));
  EXPECT_FALSE(GrowthPlot({{"", {}}}));
  EXPECT_FALSE(GrowthPlot({{"", {Judged(1000, 20, 0), Judged(2000, 0, 0)}}}));
}

TEST(GrowthPlot, NamesEachOfSeveralRunsOnceAndGivesItOneColor) {
  const std::vector<GrowthStep> small = {Judged(1000, 20, 0), Judged(2000, 25, 0.5)};
  const std::vector<GrowthStep> large = {Judged(3000, 21, 0), Judged(9000, 30, 0.1)};
  const std::optional<Plot> plot = GrowthPlot({{"small", small}, {"none", {}}, {"large", large}});
  ASSERT_TRUE(plot);
  ASSERT_EQ(plot->series.size(), 8u);
  for (size_t i = 0; i < 8; ++i) {
    EXPECT_EQ(plot->series[i].legend, i == 0 ? "small" : i == 4 ? "large" : "") << i;
    EXPECT_EQ(plot->series[i].color, i < 4 ? 0 : 2) << i;
  }
  EXPECT_EQ(plot->series[3].x, (std::vector<double>{2000, 2000}));
  EXPECT_EQ(plot->series[7].x, (std::vector<double>{9000, 9000}));
}

}  // namespace
}  // namespace tetrec
