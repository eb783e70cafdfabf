// Options that choose a value of an enumeration by its word, or parse their text.
#include "command/word_option.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetrec {
namespace {

enum class Fruit { kApple, kPear, kPlum };

}  // namespace

template <>
inline constexpr auto kWords<Fruit> = std::to_array<Word<Fruit>>({{Fruit::kApple, "apple"},
                                                                  {Fruit::kPear, "pear"},
                                                                  {Fruit::kPlum, "plum"}});

namespace {

class WordOption : public ::testing::Test {
 protected:
  WordOption() {
    AddWordOption(app_, "--fruit", fruit_, "what to eat");
    AddWordOption(app_, "--second", second_, "auto", "what to eat then");
  }
  void Parse(std::vector<std::string> arguments) {
    std::reverse(arguments.begin(), arguments.end());  // CLI11 expects them in reverse
    app_.parse(arguments);
  }

  CLI::App app_;
  Fruit fruit_ = Fruit::kPear;
  std::optional<Fruit> second_;
};

TEST_F(WordOption, KeepsItsDefaultAndShowsIt) {
  Parse({});
  EXPECT_EQ(fruit_, Fruit::kPear);
  EXPECT_EQ(second_, std::nullopt);
  EXPECT_EQ(app_.get_option("--fruit")->get_default_str(), "pear");
  EXPECT_EQ(app_.get_option("--second")->get_default_str(), "auto");
}

TEST_F(WordOption, AcceptsTheWordsOfItsValues) {
  Parse({"--fruit", "apple", "--second", "plum"});
  EXPECT_EQ(fruit_, Fruit::kApple);
  EXPECT_EQ(second_, Fruit::kPlum);
  Parse({"--second", "auto"});
  EXPECT_EQ(second_, std::nullopt);
}

TEST_F(WordOption, RefusesOtherWordsAndListsItsOwn) {
  try {
    Parse({"--fruit", "nut"});
    FAIL();
  } catch (const CLI::ValidationError& error) {
    EXPECT_EQ(std::string(error.what()), "--fruit: nut not in {apple,pear,plum}");
  }
  EXPECT_THROW(Parse({"--fruit", "auto"}), CLI::ValidationError);
}

int ParseEven(const std::string& text) {
  const int value = std::stoi(text);
  if (value % 2 != 0) throw UsageError(text + ": not an even number");
  return value;
}

TEST(ParsedOption, ReportsTheErrorsOfItsParserWithItsName) {
  CLI::App app;
  int value = 4;
  AddParsedOption(app, "--even", value, ParseEven, "4", "an even number");
  EXPECT_EQ(app.get_option("--even")->get_default_str(), "4");
  app.parse(std::vector<std::string>{"6", "--even"});
  EXPECT_EQ(value, 6);
  try {
    app.parse(std::vector<std::string>{"7", "--even"});
    FAIL();
  } catch (const CLI::ValidationError& error) {
    EXPECT_EQ(std::string(error.what()), "--even: 7: not an even number");
  }
  EXPECT_EQ(value, 6);
}

}  // namespace
}  // namespace tetrec
