// The hand-written derivatives of the segment integral against quadrature under the integral sign,
// against ceres::Jet through the product's forward function, and against ceres::Jet through the
// closed form with exact special functions.
#include "reference/quadrature.h"
#include "reference/segment_samples.h"
#include "shared/segment.glsl.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

namespace {

constexpr int kAdjointSamples = 100'000;
using Jet = ceres::Jet<double, 2>;

struct Derivatives {
  double dw0_ds0, dw0_ds1, dw1_ds0, dw1_ds1;
};

template <class Segment>
Derivatives DerivativesOf(const Segment& segment) {
  return {static_cast<double>(segment.dw0_ds0), static_cast<double>(segment.dw0_ds1),
          static_cast<double>(segment.dw1_ds0), static_cast<double>(segment.dw1_ds1)};
}

// The largest error of the four derivatives, each relative to the positive terms that it is the sum
// or difference of: dw1/ds = T/2 - dw0/ds crosses zero, so its own size is not a measure.
double Error(const Derivatives& got, const Derivatives& want, double transmittance) {
  const double by_s0 = std::abs(want.dw0_ds0), by_s1 = std::abs(want.dw0_ds1);
  const double errors[] = {std::abs(got.dw0_ds0 - want.dw0_ds0) / by_s0,
                           std::abs(got.dw0_ds1 - want.dw0_ds1) / by_s1,
                           std::abs(got.dw1_ds0 - want.dw1_ds0) / (by_s0 + 0.5 * transmittance),
                           std::abs(got.dw1_ds1 - want.dw1_ds1) / (by_s1 + 0.5 * transmittance)};
  double worst = 0;
  for (const double error : errors) {
    if (!(error <= worst)) worst = error;  // lets NaN through
  }
  return worst;
}

double MeanDepth(const reference::SegmentSample& sample) {
  return 0.5 * (double{sample.s0} + double{sample.s1});
}

TEST(SegmentAdjoint, AgreesWithQuadratureUnderTheIntegralSign) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(kAdjointSamples, 21)) {
    const reference::SegmentIntegral want = reference::IntegrateSegment(sample.s0, sample.s1);
    const auto in_float = tetrec::IntegrateSegmentWithDerivatives<float>(sample.s0, sample.s1);
    const auto in_double = tetrec::IntegrateSegmentWithDerivatives<double>(sample.s0, sample.s1);
    const auto transmittance = static_cast<double>(want.transmittance);
    // 16 nodes that stop at tau = 22 err by 1.6e-6 of m2 if the density falls to zero just there.
    // Thin segments compute T as 1 - w0 - w1, which errs by 2.1e-6 in float just below the switch.
    ASSERT_LE(Error(DerivativesOf(in_float), DerivativesOf(want), transmittance), 3e-6)
        << "s0 " << sample.s0 << " s1 " << sample.s1;
    // With six nodes at tau < 0.01 only rounding is left in double.
    ASSERT_LE(Error(DerivativesOf(in_double), DerivativesOf(want), transmittance),
              MeanDepth(sample) < 0.01 ? 2e-15 : 2e-6)
        << "s0 " << sample.s0 << " s1 " << sample.s1;
  }
}

Derivatives Differentiate(const tetrec::SegmentWeights<Jet>& weights) {
  return {weights.w0.v[0], weights.w0.v[1], weights.w1.v[0], weights.w1.v[1]};
}

// The forward function of thin segments, differentiated by Jets. The adjoint integrates the same by
// parts, so both differ by the error of the nodes, 2.5e-6 at the switch and 0 for the thinnest.
TEST(SegmentAdjoint, AgreesWithJetsThroughTheQuadratureSide) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(kAdjointSamples, 24)) {
    const double tau = MeanDepth(sample);
    if (!tetrec::IsThinSegment<double>(sample.s0, sample.s1)) continue;
    const auto forward = tetrec::IntegrateSegment(Jet(sample.s0, 0), Jet(sample.s1, 1));
    const auto adjoint = tetrec::IntegrateSegmentWithDerivatives<double>(sample.s0, sample.s1);
    ASSERT_LE(Error(Differentiate(forward), DerivativesOf(adjoint), std::exp(-tau)),
              tau < 0.01 ? 2e-15 : 3e-6)
        << "s0 " << sample.s0 << " s1 " << sample.s1;
  }
}

// Above the switch Jets differentiate the fits of erfcx and Dawson. The slope of a fit is worse
// than its value, the more so the closer the two densities are (x = s / sqrt(2 D) grows). So this
// test compares segments whose ends differ by half or more and that still let light pass; the
// others are covered by the quadrature above and by the exact closed form below.
TEST(SegmentAdjoint, AgreesWithJetsThroughTheFits) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(kAdjointSamples, 25)) {
    const double tau = MeanDepth(sample);
    if (tetrec::IsThinSegment<double>(sample.s0, sample.s1) || tau > 10) continue;
    if (std::abs(sample.s0 - sample.s1) < 0.5f * std::max(sample.s0, sample.s1)) continue;
    const auto forward = tetrec::IntegrateSegment(Jet(sample.s0, 0), Jet(sample.s1, 1));
    const auto adjoint = tetrec::IntegrateSegmentWithDerivatives<double>(sample.s0, sample.s1);
    // Measured: 9.1e-6.
    ASSERT_LE(Error(Differentiate(forward), DerivativesOf(adjoint), std::exp(-tau)), 1.5e-5)
        << "s0 " << sample.s0 << " s1 " << sample.s1;
  }
}

// erfcx and Dawson's integral from their definitions, with their derivatives
// erfcx' = 2 x erfcx - 2 / sqrt(pi), F' = 1 - 2 x F.
Jet ExactErfcx(const Jet& x) {
  const auto integrand = [&](long double t) {
    return std::array<long double, 1>{std::exp(-t * t - 2 * x.a * t)};
  };
  long double sum = 0;
  for (long double t = 0; t < 10; t += 0.5L) {
    sum += reference::IntegrateAdaptively<1>(integrand, t, t + 0.5L)[0];
  }
  const double factor = 2 / std::sqrt(std::numbers::pi);
  const double value = factor * static_cast<double>(sum);
  return {value, (2 * x.a * value - factor) * x.v};
}

Jet ExactDawson(const Jet& x) {
  const auto integrand = [&](long double u) {
    return std::array<long double, 1>{std::exp(-2 * x.a * u + u * u)};
  };
  long double sum = 0;
  for (int i = 0; i < 16; ++i) {
    sum += reference::IntegrateAdaptively<1>(integrand, x.a * i / 16, x.a * (i + 1) / 16)[0];
  }
  const auto value = static_cast<double>(sum);
  return {value, (1 - 2 * x.a * value) * x.v};
}

tetrec::SegmentWeights<Jet> ExactClosedForm(const Jet& s0, const Jet& s1) {
  const Jet t = exp(-0.5 * (s0 + s1));
  const Jet scale = 1.0 / sqrt(2.0 * abs(s1 - s0));
  const Jet mean = s1 > s0 ? std::sqrt(std::numbers::pi) * scale *
                                 (ExactErfcx(s0 * scale) - t * ExactErfcx(s1 * scale))
                           : 2.0 * scale * (ExactDawson(s0 * scale) - t * ExactDawson(s1 * scale));
  return {1.0 - mean, mean - t};
}

TEST(SegmentAdjoint, AgreesWithJetsThroughTheExactClosedForm) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(kAdjointSamples / 20, 26)) {
    const double tau = MeanDepth(sample);
    if (tetrec::IsThinSegment<double>(sample.s0, sample.s1) || tau > 10) continue;
    if (std::abs(sample.s0 - sample.s1) < 0.1f * std::max(sample.s0, sample.s1)) continue;
    const auto forward = ExactClosedForm(Jet(sample.s0, 0), Jet(sample.s1, 1));
    const auto adjoint = tetrec::IntegrateSegmentWithDerivatives<double>(sample.s0, sample.s1);
    // 16 nodes up to tau = 10 err by 6.6e-12; the closed form itself cancels about three digits.
    ASSERT_LE(Error(Differentiate(forward), DerivativesOf(adjoint), std::exp(-tau)), 1e-11)
        << "s0 " << sample.s0 << " s1 " << sample.s1;
  }
}

}  // namespace
