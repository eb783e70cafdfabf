// The part of a segment with positive density: against quadrature of the positive part of a linear
// density, and its gradients against differences of that quadrature.
#include "reference/quadrature.h"
#include "shared/integral.glsl.h"
#include "shared/segment_cut.glsl.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

namespace {

// A segment of length 1: values of density and colours at its ends.
struct Ends {
  long double d0, d1, k0, k1;
};

// The light that max(0, density) sends to the start, whose density and colour are linear, in many
// panels: the kink lies in one of them.
long double Light(const Ends& e) {
  constexpr int kPanels = 2000;
  const auto value = [&](long double s) { return e.d0 + s * (e.d1 - e.d0); };
  const auto positive = [&](long double s) { return std::max(0.0L, value(s)); };
  // The integral of the positive part of a linear function.
  const auto depth = [&](long double s) {
    if (e.d0 == e.d1) return s * positive(0);
    return (positive(s) * positive(s) - positive(0) * positive(0)) / (2 * (e.d1 - e.d0));
  };
  const auto light = [&](long double s) {
    const long double color = e.k0 + s * (e.k1 - e.k0);
    return std::array<long double, 1>{positive(s) * std::exp(-depth(s)) * color};
  };
  long double sum = 0;
  for (int i = 0; i < kPanels; ++i) {
    sum += reference::IntegratePanel<1>(light, (0.0L + i) / kPanels, (1.0L + i) / kPanels)[0];
  }
  return sum;
}

// The light and its derivatives with respect to the ends, as the renderers compute them.
struct Result {
  double light;
  std::array<double, 4> slopes;  // in the order of Ends
};

Result FromCut(const Ends& e) {
  const double d0 = double(e.d0), d1 = double(e.d1), k0 = double(e.k0), k1 = double(e.k1);
  const tetrec::SegmentCut<double> cut = tetrec::CutAtZero(d0, d1);
  const double length = cut.end - cut.begin;
  const double first = k0 + cut.begin * (k1 - k0), last = k0 + cut.end * (k1 - k0);
  const auto a = tetrec::IntegrateSegmentWithDerivatives<double>(length * tetrec::DensityOf(d0),
                                                                 length * tetrec::DensityOf(d1));
  const double by_first = length * (a.dw0_ds0 * first + a.dw1_ds0 * last);
  const double by_last = length * (a.dw0_ds1 * first + a.dw1_ds1 * last);
  return {a.w0 * first + a.w1 * last,
          {(1 - cut.begin) * by_first + (1 - cut.end) * by_last,
           cut.begin * by_first + cut.end * by_last, (1 - cut.begin) * a.w0 + (1 - cut.end) * a.w1,
           cut.begin * a.w0 + cut.end * a.w1}};
}

Ends DrawEnds(std::mt19937& random) {
  std::uniform_real_distribution<double> value(-6.0, 6.0), color(-1.0, 1.0);
  return {value(random), value(random), color(random), color(random)};
}

TEST(SegmentCut, HasTheLightOfThePositivePartOfALinearDensity) {
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    const Ends ends = DrawEnds(random);
    EXPECT_NEAR(FromCut(ends).light, double(Light(ends)), 1e-5)
        << double(ends.d0) << " " << double(ends.d1);
  }
}

TEST(SegmentCut, GradientsAreDifferencesOfTheLight) {
  std::mt19937 random(2);
  constexpr long double kStep = 1e-2L;
  for (int i = 0; i < 100; ++i) {
    const Ends ends = DrawEnds(random);
    const Result result = FromCut(ends);
    int k = 0;
    for (long double Ends::*value : {&Ends::d0, &Ends::d1, &Ends::k0, &Ends::k1}) {
      Ends more = ends, less = ends;
      more.*value += kStep;
      less.*value -= kStep;
      // Where an end passes through 0, the slope itself bends within the step.
      EXPECT_NEAR(double((Light(more) - Light(less)) / (2 * kStep)), result.slopes[size_t(k)], 2e-3)
          << "value " << k << " of " << double(ends.d0) << " " << double(ends.d1);
      ++k;
    }
  }
}

TEST(SegmentCut, StaysInTheSegmentForTinyAndHugeValues) {
  for (const float a : {1e-45f, 1e-40f, 1.0f, 3e38f}) {
    for (const float b : {1e-45f, 1e-40f, 1.0f, 3e38f}) {
      for (const auto& [d0, d1] : {std::pair(-a, b), std::pair(a, -b)}) {
        const tetrec::SegmentCut<float> cut = tetrec::CutAtZero(d0, d1);
        EXPECT_TRUE(0 <= cut.begin && cut.begin <= cut.end && cut.end <= 1) << d0 << " " << d1;
      }
    }
  }
}

TEST(SegmentCut, KeepsAllNothingOrThePartBesideThePositiveEnd) {
  const auto cut = [](double d0, double d1) {
    const auto c = tetrec::CutAtZero(d0, d1);
    return std::pair(c.begin, c.end);
  };
  EXPECT_EQ(cut(2, 3), std::pair(0.0, 1.0));
  EXPECT_EQ(cut(0, 0), std::pair(0.0, 1.0));
  EXPECT_EQ(cut(-1, 3), std::pair(0.25, 1.0));
  EXPECT_EQ(cut(3, -1), std::pair(0.0, 0.75));
  for (const auto& [d0, d1] : {std::pair(-2.0, -3.0), std::pair(-1.0, 0.0), std::pair(0.0, -1.0)}) {
    EXPECT_EQ(cut(d0, d1).first, cut(d0, d1).second) << d0 << " " << d1;
  }
}

}  // namespace
