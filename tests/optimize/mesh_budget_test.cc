#include "optimize/mesh_budget.h"

#include "core/error.h"
#include "expect_error.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

constexpr uint64_t kPixels = 4000000, kStartTets = 5000;

TrainingSet PicturesOf(uint64_t pixels, size_t photos = 100) {
  TrainingSet set;
  set.views.resize(photos);
  set.pixels = pixels;
  return set;
}

TEST(TetBudget, IsNoneUnlessTheOptionsGiveOne) {
  EXPECT_EQ(TetBudget({}, PicturesOf(kPixels), kStartTets), kNoBudget);
}

TEST(TetBudget, IsTheGivenNumberOfTets) {
  OptimizeOptions options;
  options.budget_tets = kStartTets;
  EXPECT_EQ(TetBudget(options, PicturesOf(kPixels), kStartTets), kStartTets);
  ExpectError<UsageError>([&] { TetBudget(options, PicturesOf(kPixels), kStartTets + 1); },
                          {"--budget-tets", "5,000", "5,001"});
}

TEST(TetBudget, OfMemoryIsWhatThePredictionFitsIntoIt) {
  OptimizeOptions options;
  options.budget_mb = 500;
  const uint64_t tets = TetBudget(options, PicturesOf(kPixels), kStartTets);
  EXPECT_LE(PredictedPeakBytes(3, double(tets), kPixels), 500e6);
  EXPECT_GT(PredictedPeakBytes(3, double(tets + 1), kPixels), 500e6);
  EXPECT_LT(TetBudget(options, PicturesOf(2 * kPixels), kStartTets), tets);
  // Too few photos for degree 3.
  EXPECT_GT(TetBudget(options, PicturesOf(kPixels, 15), kStartTets), tets);
}

TEST(TetBudget, OfTooLittleMemoryIsRefusedWithWhatIsNeeded) {
  OptimizeOptions options;
  options.budget_mb = 100;
  ExpectError<UsageError>([&] { TetBudget(options, PicturesOf(kPixels), kStartTets); },
                          {"203 MB", "--budget-mb allows 100"});
}

// The largest and the smallest run on lego that the prediction was made for, seven photos, and fox
// with degree 3.
TEST(PredictedPeakBytes, IsABoundOfWhatWasMeasured) {
  EXPECT_GT(PredictedPeakBytes(2, 991254, kPixels), 466e6);
  EXPECT_LT(PredictedPeakBytes(2, 991254, kPixels), 540e6);
  EXPECT_GT(PredictedPeakBytes(2, 271000, kPixels), 255e6);
  EXPECT_LT(PredictedPeakBytes(2, 271000, kPixels), 300e6);
  EXPECT_GT(PredictedPeakBytes(2, 489855, 1209600), 320e6);
  EXPECT_GT(PredictedPeakBytes(3, 716621, 5572800), 448e6);
  EXPECT_LT(PredictedPeakBytes(3, 716621, 5572800), 500e6);
}

}  // namespace
}  // namespace tetrec
