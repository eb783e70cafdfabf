// The exact orientation predicate.
#include "geometry/orientation.h"

#include <gtest/gtest.h>

#include <random>

namespace tetrec {
namespace {

// Exact for coordinates below 2^30: the determinant stays below 2^97.
int OrientationOfIntegers(const glm::ivec3 p[4]) {
  __int128 m[3][3];
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) m[i][k] = __int128(p[i + 1][k]) - p[0][k];
  }
  const __int128 determinant = m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
                               m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
                               m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
  return determinant > 0 ? 1 : determinant < 0 ? -1 : 0;
}

TEST(Orientation, IsPositiveForTheUnitTet) {
  EXPECT_EQ(Orientation({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}), 1);
  EXPECT_EQ(Orientation({0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}), -1);
  EXPECT_EQ(Orientation({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}), 0);
}

TEST(Orientation, AgreesWithWholeNumberArithmeticOnNearlyFlatTets) {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> wide(-(1 << 22), 1 << 22), narrow(-1, 1);
  int flat = 0;
  for (int n = 0; n < 20000; ++n) {
    glm::ivec3 p[4];
    for (int i = 0; i < 3; ++i) p[i] = {wide(random), wide(random), wide(random)};
    // In the plane of the others (the fourth point of a parallelogram), or one unit off it.
    p[3] = p[1] + p[2] - p[0] + glm::ivec3(narrow(random), narrow(random), narrow(random));
    const int expected = OrientationOfIntegers(p);
    flat += expected == 0;
    ASSERT_EQ(Orientation(glm::vec3(p[0]), glm::vec3(p[1]), glm::vec3(p[2]), glm::vec3(p[3])),
              expected)
        << "case " << n;
  }
  EXPECT_GT(flat, 100);
}

TEST(Orientation, ChangesSignUnderEverySwapAtAllScales) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> mantissa(-1, 1);
  for (const int exponent : {-140, -60, 0, 60, 127}) {
    std::uniform_int_distribution<int> spread(-3, 0);
    for (int n = 0; n < 500; ++n) {
      glm::vec3 p[4];
      for (auto& q : p) {
        for (int k = 0; k < 3; ++k) q[k] = std::ldexp(mantissa(random), exponent + spread(random));
      }
      p[3] = p[0] + (p[1] - p[0]) * 0.25f;  // nearly on an edge: only exact arithmetic decides
      const int sign = Orientation(p[0], p[1], p[2], p[3]);
      ASSERT_EQ(Orientation(p[1], p[0], p[2], p[3]), -sign);
      ASSERT_EQ(Orientation(p[0], p[2], p[1], p[3]), -sign);
      ASSERT_EQ(Orientation(p[0], p[1], p[3], p[2]), -sign);
      ASSERT_EQ(Orientation(p[3], p[0], p[1], p[2]), -sign);
    }
  }
}

}  // namespace
}  // namespace tetrec
