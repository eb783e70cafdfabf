#include "optimize/mesh_budget.h"

#include "core/error.h"
#include "expect_error.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

constexpr uint64_t kPixels = 4000000, kStartTets = 5000;

TEST(TetBudget, IsNoneUnlessTheOptionsGiveOne) {
  EXPECT_EQ(TetBudget({}, kPixels, kStartTets), kNoBudget);
}

TEST(TetBudget, IsTheGivenNumberOfTets) {
  OptimizeOptions options;
  options.budget_tets = kStartTets;
  EXPECT_EQ(TetBudget(options, kPixels, kStartTets), kStartTets);
  ExpectError<UsageError>([&] { TetBudget(options, kPixels, kStartTets + 1); },
                          {"--budget-tets", "5,000", "5,001"});
}

TEST(TetBudget, OfMemoryIsWhatThePredictionFitsIntoIt) {
  OptimizeOptions options;
  options.budget_mb = 500;
  const uint64_t tets = TetBudget(options, kPixels, kStartTets);
  EXPECT_LE(PredictedPeakBytes(options.harmonics, double(tets), kPixels), 500e6);
  EXPECT_GT(PredictedPeakBytes(options.harmonics, double(tets + 1), kPixels), 500e6);
  EXPECT_LT(TetBudget(options, 2 * kPixels, kStartTets), tets);
}

TEST(TetBudget, OfTooLittleMemoryIsRefusedWithWhatIsNeeded) {
  OptimizeOptions options;
  options.budget_mb = 100;
  ExpectError<UsageError>([&] { TetBudget(options, kPixels, kStartTets); },
                          {"192 MB", "--budget-mb allows 100"});
}

// The largest and the smallest run on lego that the prediction was made for, and with degree 3 fox
// and seven photos.
TEST(PredictedPeakBytes, IsABoundOfWhatWasMeasured) {
  EXPECT_GT(PredictedPeakBytes(HarmonicsChoice::kDegree2, 991254, kPixels), 466e6);
  EXPECT_LT(PredictedPeakBytes(HarmonicsChoice::kDegree2, 991254, kPixels), 540e6);
  EXPECT_GT(PredictedPeakBytes(HarmonicsChoice::kDegree2, 271000, kPixels), 255e6);
  EXPECT_LT(PredictedPeakBytes(HarmonicsChoice::kDegree2, 271000, kPixels), 300e6);
  for (const auto choice : {HarmonicsChoice::kDegree3, HarmonicsChoice::kAuto}) {
    EXPECT_GT(PredictedPeakBytes(choice, 717000, 5572800), 448e6);
    EXPECT_LT(PredictedPeakBytes(choice, 717000, 5572800), 480e6);
    EXPECT_GT(PredictedPeakBytes(choice, 489739, 1209600), 344e6);
  }
}

}  // namespace
}  // namespace tetrec
