// Enumerations and the words for their values.
#include "core/words.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

enum class Fruit { kApple, kPear, kPlum };

}  // namespace

template <>
inline constexpr auto kWords<Fruit> = std::to_array<Word<Fruit>>({{Fruit::kApple, "apple"},
                                                                  {Fruit::kPear, "pear"},
                                                                  {Fruit::kPlum, "plum"}});

namespace {

TEST(Words, NameValuesAndFindThemAgain) {
  EXPECT_STREQ(Name(Fruit::kPear), "pear");
  EXPECT_EQ(FromName<Fruit>("plum"), Fruit::kPlum);
  EXPECT_EQ(FromName<Fruit>("plu"), std::nullopt);
  EXPECT_EQ(FromName<Fruit>(""), std::nullopt);
  EXPECT_EQ(AllNames<Fruit>(), "apple, pear or plum");
  EXPECT_THROW(Name(Fruit(7)), BugError);
}

}  // namespace
}  // namespace tetrec
