// Enumerations by their words, in files and on the command line.
#include "core/words.h"

#include "core/word_option.h"

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

class WordOption : public ::testing::Test {
 protected:
  WordOption() {
    AddWordOption(app_, "--fruit", fruit_, "what to eat");
    AddWordOption(app_, "--second", second_, "auto", "what to eat then");
  }
  void Parse(std::vector<std::string> arguments) {
    std::reverse(arguments.begin(), arguments.end());  // as CLI11 wants them
    app_.parse(arguments);
  }

  CLI::App app_;
  Fruit fruit_ = Fruit::kPear;
  std::optional<Fruit> second_;
};

TEST_F(WordOption, KeepsItsDefaultAndTellsIt) {
  Parse({});
  EXPECT_EQ(fruit_, Fruit::kPear);
  EXPECT_EQ(second_, std::nullopt);
  EXPECT_EQ(app_.get_option("--fruit")->get_default_str(), "pear");
  EXPECT_EQ(app_.get_option("--second")->get_default_str(), "auto");
}

TEST_F(WordOption, TakesTheWordsOfItsValues) {
  Parse({"--fruit", "apple", "--second", "plum"});
  EXPECT_EQ(fruit_, Fruit::kApple);
  EXPECT_EQ(second_, Fruit::kPlum);
  Parse({"--second", "auto"});
  EXPECT_EQ(second_, std::nullopt);
}

TEST_F(WordOption, RefusesOtherWordsAndNamesItsOwn) {
  try {
    Parse({"--fruit", "nut"});
    FAIL();
  } catch (const CLI::ValidationError& error) {
    EXPECT_EQ(std::string(error.what()), "--fruit: nut not in {apple,pear,plum}");
  }
  EXPECT_THROW(Parse({"--fruit", "auto"}), CLI::ValidationError);
}

}  // namespace
}  // namespace tetrec
