// The reference quadrature against closed forms that need no quadrature.
#include "reference/quadrature.h"

#include "reference/segment_samples.h"

#include <gtest/gtest.h>

namespace {

TEST(Quadrature, GaussLegendreIsExactForPolynomialsOfDegree23) {
  const reference::GaussLegendre<12> rule;
  for (int degree = 0; degree <= 23; ++degree) {
    long double sum = 0;
    for (size_t i = 0; i < rule.node.size(); ++i) {
      sum += rule.weight[i] * std::pow(rule.node[i], static_cast<long double>(degree));
    }
    // The error is the rounding of twelve terms in long double.
    EXPECT_NEAR(static_cast<double>(sum * (degree + 1) - 1), 0.0, 1e-17) << "degree " << degree;
  }
}

TEST(Quadrature, ConstantDensityGivesItsClosedForm) {
  for (const long double tau : {1e-6L, 1e-3L, 0.1L, 1.0L, 1.5L, 10.0L, 100.0L, 1e4L, 1e8L}) {
    const reference::SegmentIntegral got = reference::IntegrateSegment(tau, tau);
    // M = (1 - e^-tau) / tau; w0 = 1 - M cancels for small tau, so only M and the sum are compared.
    const long double mean = -std::expm1(-tau) / tau;
    EXPECT_NEAR(static_cast<double>(got.mean_transmittance / mean - 1), 0.0, 1e-16)
        << "tau " << static_cast<double>(tau);
    EXPECT_NEAR(static_cast<double>((got.w0 + got.w1) / -std::expm1(-tau) - 1), 0.0, 1e-16)
        << "tau " << static_cast<double>(tau);
  }
}

// Identities by integration by parts, on which the product relies and the quadrature does not:
// w0 = 1 - M, w1 = M - T, dw0/ds1 + dw1/ds1 = T / 2 and so on.
TEST(Quadrature, ObeysTheIdentitiesOfIntegrationByParts) {
  for (const reference::SegmentSample& sample : reference::DrawSegments(2000, 11)) {
    const reference::SegmentIntegral got = reference::IntegrateSegment(sample.s0, sample.s1);
    const auto near = [&](long double a, long double b) {
      EXPECT_NEAR(static_cast<double>(a - b), 0.0, 1e-16)
          << "s0 " << sample.s0 << " s1 " << sample.s1;
    };
    near(got.w0, 1 - got.mean_transmittance);
    near(got.w1, got.mean_transmittance - got.transmittance);
    near(got.dw0_ds0 + got.dw1_ds0, got.transmittance / 2);
    near(got.dw0_ds1 + got.dw1_ds1, got.transmittance / 2);
  }
}

}  // namespace
