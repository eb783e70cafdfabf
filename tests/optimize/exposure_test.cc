#include "optimize/exposure.h"

#include "core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

// The sums of `rays` random rays of opaque colours, as a photo with this exposure shows them.
ExposureSums SumsOf(const ViewExposure& exposure, int rays, Random& random) {
  ExposureSums sums;
  for (int i = 0; i < rays; ++i) {
    for (int c = 0; c < 3; ++c) {
      const double x = random.Uniform();
      sums[size_t(c)].Add(x, 1.0, exposure.gain[c] * x + exposure.offset[c]);
    }
  }
  return sums;
}

std::vector<ViewExposure> RandomExposures(size_t views, double spread, Random& random) {
  std::vector<ViewExposure> exposures(views);
  for (ViewExposure& exposure : exposures) {
    for (int c = 0; c < 3; ++c) {
      exposure.gain[c] = std::exp(spread * (2 * random.Uniform() - 1));
      exposure.offset[c] = 0.2 * spread * (2 * random.Uniform() - 1);
    }
  }
  return exposures;
}

// Of the logarithms of the gains and of the offsets, in any channel.
double LargestMedian(const std::vector<ViewExposure>& exposures) {
  double largest = 0;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> gains, offsets;
    for (const ViewExposure& exposure : exposures) {
      gains.push_back(std::log(exposure.gain[c]));
      offsets.push_back(exposure.offset[c]);
    }
    for (std::vector<double>* values : {&gains, &offsets}) {
      std::sort(values->begin(), values->end());
      const size_t count = values->size();
      const double median = ((*values)[(count - 1) / 2] + (*values)[count / 2]) / 2;
      largest = std::max(largest, std::abs(median));
    }
  }
  return largest;
}

TEST(Exposure, IsFoundFromTheSumsOfManyRays) {
  Random random(1);
  const std::vector<ViewExposure> truth = RandomExposures(12, 0.3, random);
  std::vector<ExposureSums> sums;
  for (const ViewExposure& exposure : truth) sums.push_back(SumsOf(exposure, 20000, random));
  const std::vector<ViewExposure> fitted = FitExposures(sums);
  for (size_t view = 0; view < truth.size(); ++view) {
    for (int c = 0; c < 3; ++c) {
      // The pull towards neutral takes a few percent of the deviation.
      EXPECT_NEAR(fitted[view].gain[c], truth[view].gain[c], 0.05);
      EXPECT_NEAR(fitted[view].offset[c], truth[view].offset[c], 0.03);
    }
  }
}

TEST(Exposure, OfAViewThatNoRayHasSeenIsNeutral) {
  const std::vector<ExposureSums> sums(2);
  for (const ViewExposure& exposure : FitExposures(sums)) EXPECT_EQ(exposure, ViewExposure{});
}

TEST(Exposure, OfAViewOfOneColourStaysBounded) {
  ExposureSums black;
  for (int i = 0; i < 1000; ++i) {
    for (GainOffsetSums& channel : black) channel.Add(0.0, 1.0, 0.3);
  }
  const ViewExposure exposure = FitExposures(std::vector{black}).at(0);
  EXPECT_NEAR(exposure.gain.r, 1.0, 1e-9);
  EXPECT_NEAR(exposure.offset.r, 0.3, 0.05);
}

TEST(Exposure, HasANeutralMedianAfterProjectionAndKeepsItsDifferences) {
  Random random(2);
  std::vector<ViewExposure> exposures = RandomExposures(7, 0.5, random);
  const double ratio = exposures[0].gain.g / exposures[1].gain.g;
  const double difference = exposures[0].offset.b - exposures[1].offset.b;
  EXPECT_GT(LargestMedian(exposures), 1e-3);
  MakeMedianNeutral(exposures);
  EXPECT_LT(LargestMedian(exposures), 1e-15);
  EXPECT_NEAR(exposures[0].gain.g / exposures[1].gain.g, ratio, 1e-12);
  EXPECT_NEAR(exposures[0].offset.b - exposures[1].offset.b, difference, 1e-12);
}

TEST(Exposure, OfOneBlackPhotoLeavesTheOthersNeutral) {
  std::vector<ViewExposure> exposures(12);
  exposures[5].gain = glm::dvec3(0.2);
  exposures[5].offset = glm::dvec3(-0.1);
  const std::vector<ViewExposure> before = exposures;
  MakeMedianNeutral(exposures);
  EXPECT_EQ(exposures, before);
}

TEST(Exposure, OfAnEvenCollectionBecomesExactlyNeutral) {
  Random random(3);
  std::vector<ViewExposure> even = RandomExposures(20, 0.005, random);
  MakeMedianNeutral(even);
  ShrinkToEvidence(even);
  for (const ViewExposure& exposure : even) EXPECT_EQ(exposure, ViewExposure{});
}

TEST(Exposure, OfAnUnevenCollectionIsHardlyShrunk) {
  Random random(4);
  std::vector<ViewExposure> uneven = RandomExposures(20, 0.3, random);
  MakeMedianNeutral(uneven);
  const std::vector<ViewExposure> before = uneven;
  ShrinkToEvidence(uneven);
  for (size_t view = 0; view < uneven.size(); ++view) {
    EXPECT_NEAR(uneven[view].gain.r, before[view].gain.r, 0.01);
  }
  EXPECT_LT(LargestMedian(uneven), 1e-15);
}

TEST(Exposure, OfASingleViewIsNotEstimated) {
  EXPECT_FALSE(ExposureEstimate(1).is_on());
  EXPECT_FALSE(ExposureEstimate().is_on());
  EXPECT_TRUE(ExposureEstimate(2).is_on());
}

}  // namespace
}  // namespace tetrec
