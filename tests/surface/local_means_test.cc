#include "surface/local_means.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

TEST(LocalMeans, FollowWhatVariesSlowlyAndLeaveOutWhatVariesFast) {
  LocalMeans means(203, 101);
  const auto slow = [](int x, int y) {
    return glm::vec3(0.001f * float(x), -0.002f * float(y), 1);
  };
  for (int y = 0; y < 101; ++y) {
    for (int x = 0; x < 203; ++x) {
      means.Add(x, y, slow(x, y) + glm::vec3((x + y) % 2 == 0 ? 0.5f : -0.5f));
    }
  }
  means.Smooth();
  for (const glm::ivec2 pixel : {glm::ivec2(20, 20), {100, 50}, {180, 83}}) {
    const glm::vec3 off = means.At(pixel.x, pixel.y) - slow(pixel.x, pixel.y);
    EXPECT_LT(glm::length(off), 0.005f);
  }
}

// Means come from what is there: borders and gaps do not pull them to 0.
TEST(LocalMeans, ValuesBesideAGapAreTheMeanIntoIt) {
  LocalMeans means(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 32; ++x) means.Add(x, y, glm::vec3(0.25f));
  }
  means.Smooth();
  EXPECT_NEAR(means.At(0, 0).x, 0.25f, 1e-6f);
  EXPECT_NEAR(means.At(31, 63).x, 0.25f, 1e-6f);
  EXPECT_NEAR(means.At(38, 30).x, 0.25f, 1e-6f);
  EXPECT_EQ(means.At(63, 30), glm::vec3(0.0f));
}

}  // namespace
}  // namespace tetrec
