// Names of options in messages, and exit codes of programs that are not stages.
#include "command/run_command.h"

#include "command/help.h"
#include "core/error.h"
#include "core/option_range.h"
#include "expect_error.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <limits>
#include <sstream>
#include <system_error>

namespace tetrec {
namespace {

class CommandTest : public ::testing::Test {
 protected:
  CommandTest() : app_("Test.", "tetrec-test") { app_.add_option("--max-size", size_, "Size"); }

  int Run(std::vector<std::string> words, const std::function<void()>& body) {
    std::vector<char*> argv;
    words.insert(words.begin(), "tetrec");
    for (std::string& word : words) argv.push_back(word.data());
    return RunCommand(app_, int(argv.size()), argv.data(), body);
  }

  CLI::App app_;
  double size_ = 1;
};

TEST_F(CommandTest, AMessageAboutAnOptionGetsItsNameOnTheCommandLine) {
  for (const char* name : {"max_size", "max-size", "--max-size"}) {
    ExpectError<UsageError>([&] { CheckOptions(app_, [&] { CheckRange(name, 7, 1, 3); }); },
                            {"--max-size is 7; expected 1 to 3"});
  }
  ExpectError<UsageError>(
      [&] { CheckOptions(app_, [] { throw UsageError("max_size: too big"); }); },
      {"--max-size: too big"});
  ExpectError<UsageError>(
      [&] { CheckOptions(app_, [] { throw UsageError("max_size: set 'max_size' or 'none'"); }); },
      {"--max-size: set --max-size or 'none'"});
}

TEST_F(CommandTest, OtherMessagesStayAsTheyAre) {
  for (const char* message : {"max_sizes is 7", "x.raw: no layout", "", "max_size_of_all"}) {
    try {
      CheckOptions(app_, [&] { throw UsageError(message); });
      FAIL();
    } catch (const UsageError& error) {
      EXPECT_STREQ(error.what(), message);
    }
  }
}

TEST_F(CommandTest, ANumberWithAUnitIsExplained) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(Run({"--max-size", "5min"}, [] { FAIL(); }), 2);
  EXPECT_EQ(
      testing::internal::GetCapturedStderr(),
      "tetrec-test: Could not convert: --max-size = 5min; expected a number in range, without "
      "a unit (see --help)\n");
}

TEST_F(CommandTest, ExitCodesFollowTheKindOfError) {
  EXPECT_EQ(Run({}, [] {}), 0);
  EXPECT_EQ(Run({"--help"}, [] { FAIL(); }), 0);
  EXPECT_EQ(Run({"--none"}, [] { FAIL(); }), 2);
  EXPECT_EQ(Run({"--max-size", "nan"}, [] { FAIL(); }), 2);
  EXPECT_EQ(Run({}, [] { throw DataError("d"); }), 3);
  EXPECT_EQ(Run({}, [] { throw std::bad_alloc(); }), 4);
  EXPECT_EQ(Run({}, [] { throw std::logic_error("l"); }), 1);
  EXPECT_EQ(Run({}, [] { throw std::system_error(EAGAIN, std::generic_category()); }), 4);
  const char* opencv = "OpenCV(4.6.0) alloc.cpp:73: error: (-4:Insufficient memory) Failed";
  EXPECT_EQ(Run({}, [&] { throw std::runtime_error(opencv); }), 4);
}

TEST_F(CommandTest, OptionsThatAreNearlyRightGetAHint) {
  EXPECT_EQ(NearestOption(app_, "--max-siz"), "--max-size");
  EXPECT_EQ(NearestOption(app_, "--max_size=3"), "--max-size");
  EXPECT_EQ(NearestOption(app_, "--mxa-size"), "--max-size");
  EXPECT_EQ(NearestOption(app_, "--m"), "");
  EXPECT_EQ(NearestOption(app_, "--colour"), "");
}

TEST_F(CommandTest, HelpIsAtMostOneHundredColumnsWide) {
  std::string words;
  for (int i = 0; i < 80; ++i) words += "word ";
  std::string choices = "a";
  for (int i = 0; i < 80; ++i) choices += ",b" + std::to_string(i);
  app_.add_option("--choice", size_, words)->type_name(choices);
  app_.description("Example: tetrec-test\n         " + words);  // lines keep their indent
  app_.formatter(std::make_shared<HelpFormatter>());
  const std::string help = app_.help();
  EXPECT_EQ(help.rfind("Example: tetrec-test\n         word word", 0), 0u) << help;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), kHelpWidth) << line;
}

// A file that is opened next must not become the standard error.
TEST_F(CommandTest, AClosedErrorStreamIsNotReplacedByAFile) {
  const int kept = dup(STDERR_FILENO);
  close(STDERR_FILENO);
  int opened = -1;
  Run({}, [&] {
    opened = open("/dev/null", O_RDONLY);
    close(opened);
  });
  dup2(kept, STDERR_FILENO);
  close(kept);
  EXPECT_GT(opened, STDERR_FILENO);
}

TEST(OptionRange, RefusesWhatIsOutsideAndNotANumber) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  CheckRange("share", 0.0, 0.0, 1.0);
  CheckAtLeast("room", 0.0, 0.0);
  CheckAboveZero("density", 1e-9);
  ExpectError<UsageError>([] { CheckRange("share", 1.5, 0.0, 1.0); },
                          {"share is 1.5; expected 0 to 1"});
  ExpectError<UsageError>([] { CheckRange("share", kNan, 0.0, 1.0); }, {"share is nan"});
  ExpectError<UsageError>([] { CheckAtLeast("room", -1.0, 0.0); },
                          {"room is -1; expected 0 or more"});
  ExpectError<UsageError>([] { CheckAtLeast("room", kNan, 0.0); }, {"room is nan"});
  ExpectError<UsageError>([] { CheckAboveZero("density", 0); },
                          {"density is 0; expected a number above 0"});
  ExpectError<UsageError>([] { CheckAboveZero("density", kNan); }, {"density is nan"});
}

}  // namespace
}  // namespace tetrec
