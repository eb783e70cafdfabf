#include "shared/edge_hat.glsl.h"

#include <gtest/gtest.h>

#include <random>

namespace tetrec {
namespace {

TEST(EdgeHat, HasTheMeanOfManySamplesAlongASegment) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> weight(0.0, 0.5);
  constexpr int kParts = 20000;
  for (int i = 0; i < 50; ++i) {
    const double a0 = weight(random), b0 = weight(random), a1 = weight(random), b1 = weight(random);
    double sum = 0.0;
    for (int k = 0; k < kParts; ++k) {
      const double share = (k + 0.5) / kParts;
      sum += HatAt(a0 + share * (a1 - a0), b0 + share * (b1 - b0));
    }
    EXPECT_NEAR(MeanHat(a0, b0, a1, b1), sum / kParts, 1e-6);
  }
}

TEST(EdgeHat, IsOneInTheMiddleAndNothingAtTheVertices) {
  EXPECT_EQ(HatAt(0.5, 0.5), 1.0);
  EXPECT_EQ(HatAt(1.0, 0.0), 0.0);
  EXPECT_EQ(HatAt(0.0, 0.0), 0.0);
  // A segment from the face opposite one end to the face opposite the other.
  EXPECT_DOUBLE_EQ(MeanHat(0.0, 1.0, 1.0, 0.0), 0.5);
}

}  // namespace
}  // namespace tetrec
