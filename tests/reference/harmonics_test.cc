// The harmonics of view-dependent colour against quadrature over the sphere and against Boost.Math.
#include "shared/harmonics.glsl.h"

#include <boost/math/special_functions/spherical_harmonic.hpp>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace tetrec::test {
namespace {

using std::numbers::pi;

// With the constant function in place 0.
double BasisAt(int k, double x, double y, double z) {
  return k == 0 ? 0.5 / std::sqrt(pi) : Harmonic<double>(k, x, y, z);
}

// The real harmonic of degree l and order m, without the Condon-Shortley phase.
double BoostHarmonic(int l, int m, double theta, double phi) {
  if (m == 0) return boost::math::spherical_harmonic_r(unsigned(l), 0, theta, phi);
  const double phase = m % 2 == 0 ? 1.0 : -1.0;
  return phase * std::sqrt(2.0) *
         (m > 0 ? boost::math::spherical_harmonic_r(unsigned(l), m, theta, phi)
                : boost::math::spherical_harmonic_i(unsigned(l), -m, theta, phi));
}

// A product of two functions is a polynomial of degree 6 in z and in cos and sin of phi: the
// midpoint rule over 16 angles is exact in phi, and Simpson's rule over 2,000 pieces is right to
// 1e-12 in z.
TEST(Harmonics, AreOrthonormalOnTheSphere) {
  constexpr int kAngles = 16, kPieces = 2000;
  std::array<std::array<double, kMostHarmonics + 1>, kMostHarmonics + 1> products{};
  for (int i = 0; i <= kPieces; ++i) {
    const double z = -1.0 + 2.0 * i / kPieces, r = std::sqrt(std::max(0.0, 1.0 - z * z));
    const double simpson = (i == 0 || i == kPieces ? 1.0 : i % 2 == 1 ? 4.0 : 2.0) / 3.0;
    const double weight = simpson * (2.0 / kPieces) * (2.0 * pi / kAngles);
    for (int a = 0; a < kAngles; ++a) {
      const double phi = 2.0 * pi * (a + 0.5) / kAngles;
      std::array<double, kMostHarmonics + 1> basis;
      for (int k = 0; k <= kMostHarmonics; ++k) {
        basis[size_t(k)] = BasisAt(k, r * std::cos(phi), r * std::sin(phi), z);
      }
      for (size_t j = 0; j < basis.size(); ++j) {
        for (size_t k = 0; k < basis.size(); ++k) products[j][k] += weight * basis[j] * basis[k];
      }
    }
  }
  for (size_t j = 0; j < products.size(); ++j) {
    for (size_t k = 0; k < products.size(); ++k) {
      EXPECT_NEAR(products[j][k], j == k ? 1.0 : 0.0, 1e-10) << j << ", " << k;
    }
  }
}

TEST(Harmonics, AreThoseOfBoostAndBelowOne) {
  for (int l = 1; l <= kMostHarmonicDegree; ++l) {
    for (int m = -l; m <= l; ++m) {
      for (double theta = 0.05; theta < pi; theta += 0.31) {
        for (double phi = -3.0; phi < 3.0; phi += 0.41) {
          const double value = Harmonic<double>(l * l + l + m, std::sin(theta) * std::cos(phi),
                                                std::sin(theta) * std::sin(phi), std::cos(theta));
          EXPECT_NEAR(value, BoostHarmonic(l, m, theta, phi), 1e-13) << l << ", " << m;
          EXPECT_LT(std::abs(value), 1.0);
        }
      }
    }
  }
}

}  // namespace
}  // namespace tetrec::test
