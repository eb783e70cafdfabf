// The words for integrals.
#include "render/integral.h"

#include "core/error.h"
#include "expect_error.h"

#include <gtest/gtest.h>

namespace tetrec::test {
namespace {

TEST(Integral, WordsAreReadAndWrittenAlike) {
  for (const char* words : {"exact", "mean", "split:1", "split:4", "split:64"}) {
    EXPECT_EQ(Name(ParseIntegral(words)), words);
  }
  EXPECT_EQ(ParseIntegral("split:16").splits, 16);
  EXPECT_EQ(Name({}), "exact");
}

TEST(Integral, OtherWordsAreRefusedWithWhatMayStandThere) {
  for (const char* words : {"", "Exact", "exact ", "split", "linear"}) {
    ExpectError<UsageError>([&] { ParseIntegral(words); }, {words, "no such integral", "split:N"});
  }
  for (const char* words : {"split:", "split:0", "split:-1", "split:65", "split:4.5", "split:04",
                            "split:4x", "split:99999999999"}) {
    ExpectError<UsageError>([&] { ParseIntegral(words); }, {words, "parts", "1 to 64"});
  }
}

}  // namespace
}  // namespace tetrec::test
