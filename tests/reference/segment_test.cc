// The product's segment integral against quadrature and in its limits.
#include "reference/quadrature.h"
#include "reference/segment_samples.h"
#include "shared/segment.glsl.h"

#include <gtest/gtest.h>

#include <cmath>

namespace {

using reference::RelativeError;

constexpr int kSamples = 100'000;
constexpr double kExtremes[] = {0.0,  1e-40, 1e-30,     1e-20, 1e-10,     1e-7, 1e-5, 1e-3, 0.1,
                                0.5,  1.0,   1.4999999, 1.5,   1.5000001, 3.0,  10.0, 22.0, 44.0,
                                80.0, 100.0, 1e3,       1e4,   1e6,       1e9,  1e12, 1e15};

struct Worst {
  double error = 0;
  reference::SegmentSample at{};
  void Add(double candidate, const reference::SegmentSample& sample) {
    // This form lets NaN through.
    if (!(candidate <= error)) {
      error = candidate;
      at = sample;
    }
  }
};

// Records the larger relative error of w0 and w1, from either entry point.
template <class Real>
void AddWeightError(Worst& worst, const reference::SegmentSample& sample,
                    const reference::SegmentIntegral& want) {
  const auto forward = tetrec::IntegrateSegment<Real>(sample.s0, sample.s1);
  const auto adjoint = tetrec::IntegrateSegmentWithDerivatives<Real>(sample.s0, sample.s1);
  worst.Add(RelativeError(forward.w0, want.w0), sample);
  worst.Add(RelativeError(forward.w1, want.w1), sample);
  worst.Add(RelativeError(adjoint.w0, want.w0), sample);
  worst.Add(RelativeError(adjoint.w1, want.w1), sample);
}

TEST(Segment, WeightsAgreeWithQuadrature) {
  Worst in_float, in_double;
  for (const reference::SegmentSample& sample : reference::DrawSegments(kSamples, 1)) {
    const reference::SegmentIntegral want = reference::IntegrateSegment(sample.s0, sample.s1);
    AddWeightError<float>(in_float, sample, want);
    AddWeightError<double>(in_double, sample, want);
  }
  // The fits of erfcx and Dawson (4e-7 each, the larger part of M - T or 1 - M) and float rounding
  // add up to 5.5e-7 as measured. The documented bound is 8e-7.
  EXPECT_LE(in_float.error, 8e-7) << "s0 " << in_float.at.s0 << " s1 " << in_float.at.s1;
  // Without rounding, 7 nodes at the switch err by 2.2e-7, 16 nodes that stop at tau = 22
  // by 3.7e-7.
  EXPECT_LE(in_double.error, 5e-7) << "s0 " << in_double.at.s0 << " s1 " << in_double.at.s1;
}

TEST(Segment, WeightsInDoubleAreExactForThinSegments) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(kSamples / 10, 2)) {
    if (sample.s0 + sample.s1 > 0.02f) continue;
    const reference::SegmentIntegral want = reference::IntegrateSegment(sample.s0, sample.s1);
    const auto got = tetrec::IntegrateSegment<double>(sample.s0, sample.s1);
    // Seven nodes are exact up to degree 13, so for tau < 0.01 only rounding is left.
    EXPECT_LE(RelativeError(got.w0, want.w0), 2e-15) << sample.s0 << " " << sample.s1;
    EXPECT_LE(RelativeError(got.w1, want.w1), 2e-15) << sample.s0 << " " << sample.s1;
  }
}

TEST(Segment, WeightsAddUpToTheOpacity) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(kSamples, 3)) {
    const auto got = tetrec::IntegrateSegment<float>(sample.s0, sample.s1);
    const double opacity = -std::expm1(-0.5 * (double{sample.s0} + double{sample.s1}));
    // Both weights are positive and right to 8e-7, and so is their sum.
    EXPECT_LE(RelativeError(double{got.w0} + double{got.w1}, opacity), 8e-7)
        << sample.s0 << " " << sample.s1;
  }
}

// Walking the segment backwards absorbs the same light: T is symmetric.
TEST(Segment, OpacityDoesNotDependOnTheDirection) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(kSamples, 4)) {
    const auto there = tetrec::IntegrateSegment<float>(sample.s0, sample.s1);
    const auto back = tetrec::IntegrateSegment<float>(sample.s1, sample.s0);
    EXPECT_LE(RelativeError(there.w0 + there.w1, back.w0 + back.w1), 1.6e-6)
        << sample.s0 << " " << sample.s1;
  }
}

// Cutting a segment in two changes nothing: its weights follow from those of the halves.
TEST(Segment, TwoHalvesGiveTheWhole) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(kSamples / 10, 5)) {
    const double s0 = sample.s0, s1 = sample.s1, middle = 0.5 * (s0 + s1);
    const auto whole = tetrec::IntegrateSegment<double>(s0, s1);
    const auto first = tetrec::IntegrateSegment<double>(0.5 * s0, 0.5 * middle);
    const auto second = tetrec::IntegrateSegment<double>(0.5 * middle, 0.5 * s1);
    const double t = std::exp(-0.25 * (s0 + middle));
    // The colour in the middle is the mean of the ends' colours.
    const double w0 = first.w0 + 0.5 * (first.w1 + t * second.w0);
    const double w1 = 0.5 * (first.w1 + t * second.w0) + t * second.w1;
    // Each part is right to 5e-7 (see above) and all are positive.
    EXPECT_LE(RelativeError(whole.w0, w0), 1e-6) << s0 << " " << s1;
    EXPECT_LE(RelativeError(whole.w1, w1), 1e-6) << s0 << " " << s1;
  }
}

TEST(Segment, ZeroLengthOrEmptySpaceGivesExactlyNothing) {
  const auto got = tetrec::IntegrateSegmentWithDerivatives<float>(0.0f, 0.0f);
  EXPECT_EQ(tetrec::IntegrateSegment<float>(0.0f, 0.0f).w0, 0.0f);
  EXPECT_EQ(tetrec::IntegrateSegment<float>(0.0f, 0.0f).w1, 0.0f);
  EXPECT_EQ(got.w0, 0.0f);
  EXPECT_EQ(got.w1, 0.0f);
  // w0 = s0/3 + s1/6 + O(s^2), w1 = s0/6 + s1/3 + O(s^2).
  EXPECT_NEAR(got.dw0_ds0, 1.0 / 3, 2e-7);
  EXPECT_NEAR(got.dw0_ds1, 1.0 / 6, 2e-7);
  EXPECT_NEAR(got.dw1_ds0, 1.0 / 6, 2e-7);
  EXPECT_NEAR(got.dw1_ds1, 1.0 / 3, 2e-7);
}

TEST(Segment, ThinSegmentsFollowTheSeries) {
  for (const double tau : {1e-30, 1e-12, 1e-8, 1e-6}) {
    for (const double share : {0.0, 0.25, 0.5, 1.0}) {
      const double s0 = tau * share, s1 = tau * (1 - share);
      const auto got = tetrec::IntegrateSegment<double>(s0, s1);
      // The next order of the series is tau^2.
      EXPECT_NEAR(got.w0 / tau, (2 * s0 + s1) / (6 * tau), tau + 1e-15);
      EXPECT_NEAR(got.w1 / tau, (s0 + 2 * s1) / (6 * tau), tau + 1e-15);
    }
  }
}

TEST(Segment, OpaqueSegmentsShowTheirEntry) {
  for (const float s : {1e3f, 1e5f, 1e7f, 1e12f}) {
    for (const float ratio : {0.0f, 0.5f, 1.0f, 2.0f}) {
      const auto got = tetrec::IntegrateSegment<float>(s, s * ratio);
      // The light comes from a depth of 1 / s0 of the segment: w1 = 1 / s0 (1 + O(1 / s0)).
      EXPECT_NEAR(got.w0, 1.0f - 1.0f / s, 4.0f / (s * s) + 4e-7f) << s << " " << ratio;
      EXPECT_NEAR(got.w1 * s, 1.0f, 4.0f / s + 1e-6f) << s << " " << ratio;
    }
    // Density rising from zero: tau(s) = s1 s^2 / 2, M = sqrt(pi / 2 s1).
    const auto got = tetrec::IntegrateSegment<float>(0.0f, s);
    EXPECT_NEAR(got.w1 * std::sqrt(2.0f * s / 3.14159265f), 1.0f, 1e-6f) << s;
  }
}

TEST(Segment, EqualEndsGiveTheConstantDensityForm) {
  for (const double tau : kExtremes) {
    if (tau > 1e4) continue;
    const auto got =
        tetrec::IntegrateSegment<float>(static_cast<float>(tau), static_cast<float>(tau));
    const long double exact = static_cast<float>(tau);
    const long double w1 = exact < 1e-3L ? exact / 2 - exact * exact / 3 + exact * exact * exact / 8
                                         : -std::expm1(-exact) / exact - std::exp(-exact);
    if (exact < 1e-37L) continue;  // denormal floats have fewer than 24 bits
    EXPECT_LE(RelativeError(got.w1, w1), 8e-7) << tau;
  }
}

TEST(Segment, NoValueOnAGridOfExtremesIsOutsideItsRange) {
  for (const double a : kExtremes) {
    for (const double b : kExtremes) {
      const auto s0 = static_cast<float>(a), s1 = static_cast<float>(b);
      const auto forward = tetrec::IntegrateSegment<float>(s0, s1);
      const auto adjoint = tetrec::IntegrateSegmentWithDerivatives<float>(s0, s1);
      for (const float weight : {forward.w0, forward.w1, adjoint.w0, adjoint.w1}) {
        EXPECT_TRUE(weight >= 0.0f && weight <= 1.000001f) << weight << " at " << a << " " << b;
      }
      for (const float derivative :
           {adjoint.dw0_ds0, adjoint.dw0_ds1, adjoint.dw1_ds0, adjoint.dw1_ds1}) {
        EXPECT_TRUE(std::abs(derivative) <= 0.5f) << derivative << " at " << a << " " << b;
      }
      // If the entry is denser, w1 never exceeds w0, and w0 never falls when a density rises.
      EXPECT_GE(adjoint.dw0_ds0, 0.0f) << a << " " << b;
      EXPECT_GE(adjoint.dw0_ds1, 0.0f) << a << " " << b;
    }
  }
}

TEST(Segment, TheShareAtWhichADepthIsReachedHasThisDepthInFrontOfIt) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(kSamples, 3)) {
    const long double s0 = sample.s0, s1 = sample.s1, all = (s0 + s1) / 2;
    for (const double part : {0.0, 1e-6, 0.3, 0.999, 1.0}) {
      const float tau = static_cast<float>(part * static_cast<double>(all));
      const double in_double = tetrec::ReachInSegment<double>(sample.s0, sample.s1, tau);
      const float in_float = tetrec::ReachInSegment<float>(sample.s0, sample.s1, tau);
      for (const long double u :
           {static_cast<long double>(in_double), static_cast<long double>(in_float)}) {
        ASSERT_TRUE(u >= 0 && u <= 1) << sample.s0 << " " << sample.s1 << " " << tau;
      }
      // The depth in front of the place: the integral of (1 - s) s0 + s s1 from 0 to u. Rounding of
      // the root moves a place by a few of its own roundings, and depth by at most
      // u (s0 + (s1 - s0) u) times that; tau was rounded to a float, so it may exceed the end.
      const long double u = in_double, in_front = s0 * u + (s1 - s0) * u * u / 2;
      ASSERT_LE(std::abs(in_front - std::min<long double>(tau, all)), 1e-7L * all + 1e-30L)
          << sample.s0 << " " << sample.s1 << " " << tau;
      ASSERT_NEAR(in_float, in_double, 2e-3 * in_double + 1e-6)
          << sample.s0 << " " << sample.s1 << " " << tau;
    }
  }
}

TEST(SpecialFunctions, FitsAgreeWithTheirDefinitions) {
  double worst_erfcx = 0, worst_dawson = 0;
  for (double x = 1e-5; x < 1e5; x *= 1.1) {
    // erfcx(x) = 2/sqrt(pi) int_0^inf e^(-t^2 - 2 x t) dt; F(x) = int_0^x e^(-2 x u + u^2) du.
    const auto integrand = [x](long double t) {
      return std::array<long double, 2>{std::exp(-t * t - 2 * x * t),
                                        t < x ? std::exp(-2 * x * t + t * t) : 0.0L};
    };
    const auto integrate = [&](long double end, size_t which) {
      const auto one = [&](long double t) {
        return std::array<long double, 1>{integrand(t)[which]};
      };
      long double sum = 0, begin = 0;
      for (long double next = std::min(end, 0.1L / (1 + x)); begin < end;
           begin = next, next = std::min(end, 2 * next)) {
        sum += reference::IntegrateAdaptively<1>(one, begin, next)[0];
      }
      return sum;
    };
    const long double erfcx = 2 / std::sqrt(std::numbers::pi_v<long double>) * integrate(10, 0);
    worst_erfcx = std::max(worst_erfcx, RelativeError(tetrec::Erfcx<double>(x), erfcx));
    worst_dawson =
        std::max(worst_dawson, RelativeError(tetrec::Dawson<double>(x), integrate(x, 1)));
  }
  // The bound in the header (4e-7) is for float; the fits alone are better.
  EXPECT_LE(worst_erfcx, 4e-7);
  EXPECT_LE(worst_dawson, 4e-7);
}

}  // namespace
