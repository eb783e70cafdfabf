// The words of --loss.
#include "render/loss.h"

#include "core/error.h"
#include "expect_error.h"

#include <gtest/gtest.h>

namespace tetrec::test {
namespace {

TEST(Loss, WordsNameThePixelLossAndTheShareOfDssim) {
  EXPECT_EQ(ParseLoss("l1").pixel, LossKind::kL1);
  EXPECT_EQ(ParseLoss("l2").pixel, LossKind::kL2);
  EXPECT_EQ(ParseLoss("l2").dssim, 0.0);
  EXPECT_EQ(ParseLoss("l1+dssim:0.2").pixel, LossKind::kL1);
  EXPECT_EQ(ParseLoss("l1+dssim:0.2").dssim, 0.2);
  EXPECT_EQ(ParseLoss("l2+dssim:1").pixel, LossKind::kL2);
  EXPECT_EQ(ParseLoss("l2+dssim:1").dssim, 1.0);
}

TEST(Loss, OtherWordsAreRefusedWithWhatMayStandThere) {
  for (const char* words : {"", "L1", "l3", "l1 ", "dssim:0.2", "l1+", "l1+ssim:0.2", "l1+l2"}) {
    ExpectError<UsageError>([&] { ParseLoss(words); }, {"--loss", words, "l1+dssim:W"});
  }
  for (const char* words : {"l1+dssim:", "l1+dssim:0", "l2+dssim:-0.2", "l1+dssim:1.01",
                            "l1+dssim:nan", "l1+dssim:0.2x", "l1+dssim:1e999"}) {
    ExpectError<UsageError>([&] { ParseLoss(words); }, {"--loss", words, "above 0, at most 1"});
  }
}

}  // namespace
}  // namespace tetrec::test
