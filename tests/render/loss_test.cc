// The words for losses.
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
  for (const char* words : {"l1", "l2", "l1+dssim:0.2", "l2+dssim:1"})
    EXPECT_EQ(Name(ParseLoss(words)), words);
}

TEST(Loss, OtherWordsAreRefusedWithTheValidOnes) {
  for (const char* words : {"", "L1", "l3", "l1 ", "dssim:0.2", "l1+", "l1+ssim:0.2", "l1+l2"}) {
    ExpectError<UsageError>([&] { ParseLoss(words); }, {words, "no such loss", "l1+dssim:W"});
  }
  for (const char* words : {"l1+dssim:", "l1+dssim:0", "l2+dssim:-0.2", "l1+dssim:1.01",
                            "l1+dssim:nan", "l1+dssim:0.2x", "l1+dssim:1e999"}) {
    ExpectError<UsageError>([&] { ParseLoss(words); }, {words, "weight", "above 0 and at most 1"});
  }
}

}  // namespace
}  // namespace tetrec::test
