#include "core/spread_choice.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(SpreadChoice, TakesItemsFromAllPartsOfTheirSequence) {
  const std::vector<int> items{0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_EQ(SpreadChoice<int>(items, 5), (std::vector{0, 2, 4, 6, 8}));
  EXPECT_EQ(SpreadChoice<int>(items, 3), (std::vector{0, 3, 6}));
  EXPECT_EQ(SpreadChoice<int>(items, 1), (std::vector{0}));
}

TEST(SpreadChoice, TakesAllIfThereAreNoMore) {
  const std::vector<int> items{5, 6, 7};
  EXPECT_EQ(SpreadChoice<int>(items, 3), items);
  EXPECT_EQ(SpreadChoice<int>(items, 100), items);
  EXPECT_TRUE(SpreadChoice<int>(items, 0).empty());
  EXPECT_TRUE(SpreadChoice<int>({}, 4).empty());
}

}  // namespace
}  // namespace tetrec
