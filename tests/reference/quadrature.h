// Emission and absorption along one segment by adaptive quadrature in long double, straight from
// the integral. It shares no header with the product.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace reference {

// The error of `got` as a share of `want`, or as it is where nothing is wanted.
inline double RelativeError(double got, long double want) {
  if (want == 0) return std::abs(got);
  return static_cast<double>(std::abs(got - want) / std::abs(want));
}

// Gauss-Legendre nodes and weights on [0, 1], by Newton's method on the Legendre polynomial.
template <int kNodes>
struct GaussLegendre {
  std::array<long double, kNodes> node, weight;

  GaussLegendre() {
    for (int i = 0; i < kNodes; ++i) {
      long double x = std::cos(std::numbers::pi_v<long double> * (i + 0.75L) / (kNodes + 0.5L));
      long double slope = 0;
      for (int iteration = 0; iteration < 20; ++iteration) {
        long double previous = 1, value = x;  // P_0, P_1
        for (int k = 2; k <= kNodes; ++k) {
          const long double next = ((2 * k - 1) * x * value - (k - 1) * previous) / k;
          previous = value;
          value = next;
        }
        slope = kNodes * (previous - x * value) / (1 - x * x);
        x -= value / slope;
      }
      node[i] = 0.5L * (1 - x);
      weight[i] = 1 / ((1 - x * x) * slope * slope);
    }
  }
};

template <size_t kValues, class Integrand>
std::array<long double, kValues> IntegratePanel(const Integrand& integrand, long double begin,
                                                long double end) {
  static const GaussLegendre<12> rule;
  std::array<long double, kValues> sum{};
  for (size_t i = 0; i < rule.node.size(); ++i) {
    const std::array<long double, kValues> value = integrand(begin + (end - begin) * rule.node[i]);
    for (size_t k = 0; k < kValues; ++k) sum[k] += (end - begin) * rule.weight[i] * value[k];
  }
  return sum;
}

// Halves the panel until the sum of the halves agrees with the whole to about 1e-17 of the panel.
template <size_t kValues, class Integrand>
std::array<long double, kValues> IntegrateAdaptively(const Integrand& integrand, long double begin,
                                                     long double end, int depth = 0) {
  const auto whole = IntegratePanel<kValues>(integrand, begin, end);
  const long double middle = 0.5L * (begin + end);
  auto left = IntegratePanel<kValues>(integrand, begin, middle);
  auto right = IntegratePanel<kValues>(integrand, middle, end);
  bool agree = true;
  for (size_t k = 0; k < kValues; ++k) {
    const long double scale = std::abs(left[k]) + std::abs(right[k]);
    agree = agree && std::abs(left[k] + right[k] - whole[k]) <= 1e-17L * scale;
  }
  if (!agree && depth < 6) {
    left = IntegrateAdaptively<kValues>(integrand, begin, middle, depth + 1);
    right = IntegrateAdaptively<kValues>(integrand, middle, end, depth + 1);
  }
  for (size_t k = 0; k < kValues; ++k) left[k] += right[k];
  return left;
}

// A segment with the optical depths per unit fraction s0 at its start and s1 at its end:
//   sigma(s) = (1 - s) s0 + s s1,   tau(s) = s0 s + (s1 - s0) s^2 / 2,
//   w0 = int_0^1 sigma e^-tau (1 - s) ds,   w1 = int_0^1 sigma e^-tau s ds,   T = e^-tau(1).
struct SegmentIntegral {
  long double w0, w1, transmittance;
  long double mean_transmittance;  // M = int_0^1 e^-tau ds
  // Derivatives by s0 and s1, taken under the integral sign.
  long double dw0_ds0, dw0_ds1, dw1_ds0, dw1_ds1;
};

inline SegmentIntegral IntegrateSegment(long double s0, long double s1) {
  const auto tau = [=](long double s) { return s0 * s * (1 - s / 2) + s1 * s * s / 2; };
  const auto integrand = [=](long double s) {
    const long double t = std::exp(-tau(s)), sigma = (1 - s) * s0 + s * s1;
    const long double dtau_ds0 = s - s * s / 2, dtau_ds1 = s * s / 2;
    const long double by_s0 = t * ((1 - s) - sigma * dtau_ds0);
    const long double by_s1 = t * (s - sigma * dtau_ds1);
    return std::array<long double, 7>{t * sigma * (1 - s), t * sigma * s, t,        by_s0 * (1 - s),
                                      by_s1 * (1 - s),     by_s0 * s,     by_s1 * s};
  };
  // The integrand changes most where tau is about 1: panels start small and double in size.
  std::array<long double, 7> sum{};
  long double begin = 0;
  long double end = std::min(1.0L, 0.25L / (s0 + std::sqrt(s1) + 1e-30L));
  while (begin < 1) {
    const auto panel = IntegrateAdaptively<7>(integrand, begin, end);
    for (size_t k = 0; k < sum.size(); ++k) sum[k] += panel[k];
    begin = end;
    // Beyond tau = 100 the share of any result is below 4e-44.
    if (tau(begin) > 100) break;
    end = std::min(1.0L, 2 * end);
  }
  return {sum[0], sum[1], std::exp(-tau(1)), sum[2], sum[3], sum[4], sum[5], sum[6]};
}

}  // namespace reference
