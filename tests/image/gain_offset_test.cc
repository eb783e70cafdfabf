#include "image/gain_offset.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

GainOffsetSums SumsOf(double gain, double offset, double opacity = 1) {
  GainOffsetSums sums;
  for (int i = 0; i < 20; ++i) {
    const double x = std::abs(std::sin(1.7 * i)), w = opacity;
    sums.Add(x, w, gain * x + offset * w);
  }
  return sums;
}

double Cost(const GainOffsetSums& s, const GainOffsetPrior& prior, double gain, double offset) {
  return gain * gain * s.xx + 2 * gain * offset * s.xw + offset * offset * s.ww - 2 * gain * s.yx -
         2 * offset * s.yw + prior.gain * (gain - 1) * (gain - 1) + prior.offset * offset * offset;
}

TEST(GainOffset, IsFoundExactlyWhereThereIsNoNoise) {
  for (const double opacity : {1.0, 0.3}) {
    const GainOffset fit = FitGainOffset(SumsOf(0.7, 0.1, opacity)).value();
    EXPECT_NEAR(fit.gain, 0.7, 1e-12);
    EXPECT_NEAR(fit.offset, 0.1, 1e-12);
  }
}

TEST(GainOffset, HasTheLeastCost) {
  const GainOffsetSums sums = SumsOf(0.7, 0.1);
  const GainOffsetPrior prior{3, 5};
  const GainOffset fit = FitGainOffset(sums, prior).value();
  const double least = Cost(sums, prior, fit.gain, fit.offset);
  for (const double step : {-1e-3, 1e-3}) {
    EXPECT_GT(Cost(sums, prior, fit.gain + step, fit.offset), least);
    EXPECT_GT(Cost(sums, prior, fit.gain, fit.offset + step), least);
  }
}

TEST(GainOffset, IsPulledToNeutralByAStrongPrior) {
  const GainOffset fit = FitGainOffset(SumsOf(0.7, 0.1), {1e9, 1e9}).value();
  EXPECT_NEAR(fit.gain, 1, 1e-6);
  EXPECT_NEAR(fit.offset, 0, 1e-6);
}

TEST(GainOffset, IsUnknownWhereAllColoursAreEqual) {
  GainOffsetSums sums;
  EXPECT_FALSE(FitGainOffset(sums));
  for (int i = 0; i < 10; ++i) sums.Add(0.3, 1.0, 0.1 * i);
  EXPECT_FALSE(FitGainOffset(sums));
  EXPECT_TRUE(FitGainOffset(sums, {1, 1}));
}

}  // namespace
}  // namespace tetrec
