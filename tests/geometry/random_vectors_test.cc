// Random points, directions and rotations.
#include "geometry/random_vectors.h"

#include "geometry/rotation.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

constexpr int kDraws = 20000;
// Four standard errors of a mean of variables whose variance is at most 1 / 2.
const double kMeanTolerance = 4 * std::sqrt(0.5 / kDraws);

TEST(RandomVectors, DirectionsAreUnitAndFavourNone) {
  MersenneRandom random(3);
  glm::dvec3 sum(0.0);
  glm::dmat3 second(0.0);
  for (int i = 0; i < kDraws; ++i) {
    const glm::dvec3 d = RandomDirection(random);
    ASSERT_NEAR(glm::length(d), 1, 1e-14);
    sum += d;
    second += glm::outerProduct(d, d);
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(sum[i] / kDraws, 0, kMeanTolerance);
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(second[i][k] / kDraws, i == k ? 1.0 / 3 : 0, kMeanTolerance);
    }
  }
}

TEST(RandomVectors, QuaternionsAreUnitAndTurnAnyVectorAnywhere) {
  MersenneRandom random(4);
  glm::dmat3 sum(0.0);
  for (int i = 0; i < kDraws; ++i) {
    const glm::dmat3 rotation = glm::mat3_cast(RandomQuaternion(random));
    ASSERT_LT(DistanceFromRotation(rotation), 1e-14);
    sum += rotation;
  }
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(sum[i / 3][i % 3] / kDraws, 0, kMeanTolerance);
}

TEST(RandomVectors, PointsFillTheUnitCube) {
  MersenneRandom random(5);
  glm::dvec3 low(1.0), high(0.0), sum(0.0);
  for (int i = 0; i < kDraws; ++i) {
    const glm::dvec3 p = RandomInUnitCube(random);
    low = glm::min(low, p);
    high = glm::max(high, p);
    sum += p;
  }
  for (int i = 0; i < 3; ++i) {
    EXPECT_GE(low[i], 0);
    EXPECT_LT(high[i], 1);
    EXPECT_NEAR(sum[i] / kDraws, 0.5, kMeanTolerance);
  }
}

}  // namespace
}  // namespace tetrec
