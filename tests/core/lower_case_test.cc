// ASCII letters in lower case.
#include "core/lower_case.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(LowerCase, LowersAsciiLettersAlone) {
  EXPECT_EQ(Lower("aBZz 09_-\xC3\x84"), "abzz 09_-\xC3\x84");
  EXPECT_EQ(LowerExtension("A/B.tar.JPG"), ".jpg");
  EXPECT_EQ(LowerExtension("A/B"), "");
}

}  // namespace
}  // namespace tetrec
