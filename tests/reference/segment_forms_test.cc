// The integrals by the mean density and by parts of constant density: against quadrature of the
// same densities, in their limits, in their convergence to the exact integral, and their
// derivatives against ceres::Jet.
#include "reference/quadrature.h"
#include "reference/segment_samples.h"
#include "shared/integral.glsl.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace {

using reference::RelativeError;
using reference::SegmentSample;
using Jet = ceres::Jet<double, 2>;

constexpr int kFormSamples = 20'000;
constexpr int kParts[] = {1, 2, 3, 4, 16, 64};

struct Weights {
  long double w0, w1;
};

// Parts of constant density, each by quadrature, composited in long double.
Weights SplitByQuadrature(int parts, long double s0, long double s1) {
  Weights sum{0, 0};
  long double depth = 0;
  for (int i = 0; i < parts; ++i) {
    const long double tau = (s0 + (s1 - s0) * (i + 0.5L) / parts) / parts;
    const reference::SegmentIntegral part = reference::IntegrateSegment(tau, tau);
    sum.w0 +=
        std::exp(-depth) * (part.w0 * (parts - i) + part.w1 * (parts - i - 1)) / (1.0L * parts);
    sum.w1 += std::exp(-depth) * (part.w0 * i + part.w1 * (i + 1)) / (1.0L * parts);
    depth += tau;
  }
  return sum;
}

// n parts round the transmittance n times, by 1e-7 each and in the worst case all the same way.
double FloatTolerance(int parts) { return 1e-6 + 1e-7 * parts; }

// The error of the fit for thin parts, and so of everything computed from it.
constexpr double kDoubleTolerance = 2e-9;

TEST(MeanSegment, AgreesWithQuadratureOfTheMeanDensity) {
  for (const SegmentSample& sample : reference::DrawSegments(kFormSamples, 31)) {
    const Weights want = SplitByQuadrature(1, sample.s0, sample.s1);
    const auto in_float = tetrec::IntegrateMeanSegment<float>(sample.s0, sample.s1);
    const auto in_double = tetrec::IntegrateMeanSegment<double>(sample.s0, sample.s1);
    // From tau = 1 on, 1 - M and M - T are used; there they err by 4 and 5 roundings.
    ASSERT_LE(RelativeError(in_float.w0, want.w0), 8e-7) << sample.s0 << " " << sample.s1;
    ASSERT_LE(RelativeError(in_float.w1, want.w1), 8e-7) << sample.s0 << " " << sample.s1;
    ASSERT_LE(RelativeError(in_double.w0, want.w0), kDoubleTolerance);
    ASSERT_LE(RelativeError(in_double.w1, want.w1), kDoubleTolerance);
  }
}

TEST(SplitSegment, AgreesWithQuadratureOfItsParts) {
  for (const int parts : kParts) {
    for (const SegmentSample& sample : reference::DrawSegments(kFormSamples / (10 * parts), 32)) {
      const Weights want = SplitByQuadrature(parts, sample.s0, sample.s1);
      const auto in_float = tetrec::IntegrateSplitSegment<float>(parts, sample.s0, sample.s1);
      const auto in_double = tetrec::IntegrateSplitSegment<double>(parts, sample.s0, sample.s1);
      SCOPED_TRACE(::testing::Message() << parts << ": " << sample.s0 << " " << sample.s1);
      ASSERT_LE(RelativeError(in_float.w0, want.w0), FloatTolerance(parts));
      ASSERT_LE(RelativeError(in_float.w1, want.w1), FloatTolerance(parts));
      ASSERT_LE(RelativeError(in_double.w0, want.w0), kDoubleTolerance);
      ASSERT_LE(RelativeError(in_double.w1, want.w1), kDoubleTolerance);
    }
  }
}

TEST(SplitSegment, OnePartIsTheMeanDensity) {
  for (const SegmentSample& sample : reference::DrawSegments(kFormSamples, 33)) {
    const auto split =
        tetrec::IntegrateSplitSegmentWithDerivatives<double>(1, sample.s0, sample.s1);
    const auto mean = tetrec::IntegrateMeanSegmentWithDerivatives<double>(sample.s0, sample.s1);
    // The formulas are the same except for the order of a sum.
    ASSERT_LE(RelativeError(split.w0, mean.w0), 1e-14);
    ASSERT_LE(RelativeError(split.w1, mean.w1), 1e-14);
    ASSERT_LE(RelativeError(split.dw0_ds0, mean.dw0_ds0), 1e-14);
    ASSERT_LE(RelativeError(split.dw0_ds1, mean.dw0_ds1), 1e-14);
  }
}

// Interpolating the depth linearly over n parts leaves an error of order 1 / n^2.
TEST(SplitSegment, TwiceThePartsLeaveAQuarterOfTheError) {
  for (const auto& [s0, s1] :
       {SegmentSample{0.1f, 0.5f}, {0.0f, 2.0f}, {2.0f, 0.0f}, {1.0f, 7.0f}}) {
    const reference::SegmentIntegral exact = reference::IntegrateSegment(s0, s1);
    const auto error = [&s0 = s0, &s1 = s1, &exact](int parts) {
      return static_cast<double>(tetrec::IntegrateSplitSegment<double>(parts, s0, s1).w1 -
                                 exact.w1);
    };
    for (const int parts : {4, 8, 16, 32}) {
      // The next order is smaller by 1 / n^2 times a factor that grows with the depth.
      EXPECT_NEAR(error(parts) / error(2 * parts), 4.0, 12.0 / (parts * parts) + 1e-3)
          << parts << " parts, s0 " << s0 << ", s1 " << s1;
    }
  }
}

// When the difference of the ends is halved, the error of the mean density is at least halved.
TEST(MeanSegment, BecomesExactAsTheDensitiesBecomeEqual) {
  for (const double tau : {0.01, 0.5, 3.0, 30.0}) {
    double before = 1;
    for (double share = 0.5; share > 1e-4; share *= 0.5) {
      const double s0 = tau * (1 + share), s1 = tau * (1 - share);
      const double error = RelativeError(tetrec::IntegrateMeanSegment<double>(s0, s1).w1,
                                         reference::IntegrateSegment(s0, s1).w1);
      EXPECT_LE(error, 0.55 * before) << tau << " " << share;
      before = error;
    }
    EXPECT_LE(RelativeError(tetrec::IntegrateMeanSegment<double>(tau, tau).w0,
                            reference::IntegrateSegment(tau, tau).w0),
              kDoubleTolerance);
  }
}

TEST(AllIntegrals, AreTheSameForEqualDensities) {
  for (const double tau : {0.0, 1e-8, 1e-3, 0.3, 0.999, 1.0, 2.4, 2.6, 17.0, 1e4}) {
    const reference::SegmentIntegral want = reference::IntegrateSegment(tau, tau);
    for (const int integral : {kIntegralExact, kIntegralMean, kIntegralSplit}) {
      for (const int parts : kParts) {
        const auto got = tetrec::IntegrateSegmentBy<double>(integral, parts, tau, tau);
        // 5e-7 is the error of the exact form on thick segments.
        EXPECT_LE(RelativeError(got.w0, want.w0), 5e-7) << integral << " " << parts << " " << tau;
        EXPECT_LE(RelativeError(got.w1, want.w1), 5e-7) << integral << " " << parts << " " << tau;
      }
    }
  }
}

TEST(AllIntegrals, HaveWeightsThatAddUpToTheOpacity) {
  for (const int parts : kParts) {
    for (const SegmentSample& sample : reference::DrawSegments(kFormSamples / 10, 34)) {
      const double opacity = -std::expm1(-0.5 * (double{sample.s0} + double{sample.s1}));
      for (const int integral : {kIntegralExact, kIntegralMean, kIntegralSplit}) {
        const auto got = tetrec::IntegrateSegmentBy<float>(integral, parts, sample.s0, sample.s1);
        ASSERT_LE(RelativeError(double{got.w0} + double{got.w1}, opacity), FloatTolerance(parts))
            << integral << " " << parts << ": " << sample.s0 << " " << sample.s1;
      }
    }
  }
}

TEST(AllIntegrals, ShowNothingOfEmptySpaceAndGrowByHalfTheDensities) {
  for (const int integral : {kIntegralMean, kIntegralSplit}) {
    for (const int parts : kParts) {
      const auto got =
          tetrec::IntegrateSegmentByWithDerivatives<float>(integral, parts, 0.0f, 0.0f);
      EXPECT_EQ(got.w0, 0.0f);
      EXPECT_EQ(got.w1, 0.0f);
      // With n parts of mean density the hat functions' integrals 1/3 and 1/6 err by 1 / 12 n^2.
      const double n = integral == kIntegralMean ? 1 : parts, error = 1 / (12 * n * n);
      EXPECT_NEAR(got.dw0_ds0, 1.0 / 3 - error, 5e-7);
      EXPECT_NEAR(got.dw0_ds1, 1.0 / 6 + error, 5e-7);
      EXPECT_NEAR(got.dw1_ds0, 1.0 / 6 + error, 5e-7);
      EXPECT_NEAR(got.dw1_ds1, 1.0 / 3 - error, 5e-7);
    }
  }
}

TEST(AllIntegrals, StayInTheirRangeOnAGridOfExtremes) {
  const float extremes[] = {0.0f, 1e-40f, 1e-30f, 1e-8f, 1e-3f, 0.5f,  0.9999999f, 1.0f,
                            2.0f, 4.0f,   64.0f,  1e4f,  1e6f,  1e12f, 1e15f};
  for (const int integral : {kIntegralExact, kIntegralMean, kIntegralSplit}) {
    for (const int parts : kParts) {
      for (const float s0 : extremes) {
        for (const float s1 : extremes) {
          const auto got = tetrec::IntegrateSegmentByWithDerivatives(integral, parts, s0, s1);
          SCOPED_TRACE(::testing::Message() << integral << " " << parts << ": " << s0 << " " << s1);
          for (const float weight : {got.w0, got.w1}) {
            EXPECT_TRUE(weight >= 0.0f && weight <= 1.0f + 1e-7f * float(parts + 10)) << weight;
          }
          for (const float slope : {got.dw0_ds0, got.dw0_ds1, got.dw1_ds0, got.dw1_ds1}) {
            EXPECT_TRUE(std::abs(slope) <= 0.5f) << slope;
          }
        }
      }
    }
  }
}

void ExpectDerivativesOfJets(int integral, int parts, const SegmentSample& sample) {
  const auto forward =
      tetrec::IntegrateSegmentBy(integral, parts, Jet(sample.s0, 0), Jet(sample.s1, 1));
  const auto adjoint =
      tetrec::IntegrateSegmentByWithDerivatives<double>(integral, parts, sample.s0, sample.s1);
  SCOPED_TRACE(::testing::Message() << parts << ": " << sample.s0 << " " << sample.s1);
  // Both are sums of parts below 1/2 that cancel, so the rounding error is absolute.
  ASSERT_NEAR(adjoint.w0, forward.w0.a, 1e-15);
  ASSERT_NEAR(adjoint.w1, forward.w1.a, 1e-15);
  ASSERT_NEAR(adjoint.dw0_ds0, forward.w0.v[0], 1e-12);
  ASSERT_NEAR(adjoint.dw0_ds1, forward.w0.v[1], 1e-12);
  ASSERT_NEAR(adjoint.dw1_ds0, forward.w1.v[0], 1e-12);
  ASSERT_NEAR(adjoint.dw1_ds1, forward.w1.v[1], 1e-12);
}

TEST(MeanSegment, DerivativesAreThoseOfJetsThroughTheForward) {
  for (const SegmentSample& sample : reference::DrawSegments(kFormSamples, 35)) {
    ExpectDerivativesOfJets(kIntegralMean, 1, sample);
  }
}

TEST(SplitSegment, DerivativesAreThoseOfJetsThroughTheForward) {
  for (const int parts : kParts) {
    for (const SegmentSample& sample : reference::DrawSegments(kFormSamples / 10, 36)) {
      ExpectDerivativesOfJets(kIntegralSplit, parts, sample);
    }
  }
}

// In float, terms of order 1 / n are added and cancel down to the derivative. The rounding error is
// absolute, relative to the largest sum, and each of the n transmittances contributes one.
TEST(AllIntegrals, DerivativesInFloatAreThoseInDouble) {
  for (const int integral : {kIntegralMean, kIntegralSplit}) {
    for (const int parts : kParts) {
      for (const SegmentSample& sample : reference::DrawSegments(kFormSamples / 10, 37)) {
        const auto in_float =
            tetrec::IntegrateSegmentByWithDerivatives<float>(integral, parts, sample.s0, sample.s1);
        const auto in_double = tetrec::IntegrateSegmentByWithDerivatives<double>(
            integral, parts, sample.s0, sample.s1);
        SCOPED_TRACE(::testing::Message()
                     << integral << " " << parts << ": " << sample.s0 << " " << sample.s1);
        const double tolerance = FloatTolerance(parts) * 0.5;
        ASSERT_NEAR(in_float.dw0_ds0, in_double.dw0_ds0, tolerance);
        ASSERT_NEAR(in_float.dw0_ds1, in_double.dw0_ds1, tolerance);
        ASSERT_NEAR(in_float.dw1_ds0, in_double.dw1_ds0, tolerance);
        ASSERT_NEAR(in_float.dw1_ds1, in_double.dw1_ds1, tolerance);
      }
    }
  }
}

}  // namespace
