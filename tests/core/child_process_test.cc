// Child processes: arguments, output, exit codes, time limits, missing programs.
#include "core/child_process.h"

#include "core/error.h"
#include "core/file.h"
#include "core/message_of.h"
#include "core/timer.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tetrec {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

ChildResult Shell(const std::string& script, ChildOptions options = {}) {
  return RunChild("/bin/sh", {"-c", script}, options);
}

TEST(ChildProcess, ArgumentsAreNotReadByAShell) {
  const ChildResult result = RunChild(FindProgram("printf"), {"%s\\n", "$HOME; `id` 'x y'"}, {});
  EXPECT_THAT(result.last_lines, ElementsAre("$HOME; `id` 'x y'"));
}

TEST(ChildProcess, OutputAndErrorsArriveAsLinesAndInTheLog) {
  const ScratchFolder folder;
  std::vector<std::string> lines;
  ChildOptions options;
  options.log = folder / "log.txt";
  options.working_folder = folder.path();
  options.environment = {{"TETREC_TEST", "seen"}};
  options.on_line = [&](const std::string& line) { lines.push_back(line); };
  const ChildResult result = Shell(
      "echo one; echo $TETREC_TEST >&2; printf 'a\\rlast'; basename $(pwd)>x; exit 3", options);
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_THAT(lines, ElementsAre("one", "seen", "a", "last"));
  EXPECT_EQ(ReadText(folder / "log.txt"), "one\nseen\na\nlast\n");
  EXPECT_EQ(ReadText(folder / "x"), folder.path().filename().string() + "\n");
}

TEST(ChildProcess, OnlyTheLastTwentyLinesAreKept) {
  const ChildResult result = Shell("i=0; while [ $i -lt 100 ]; do echo $i; i=$((i+1)); done");
  ASSERT_EQ(result.last_lines.size(), 20u);
  EXPECT_EQ(result.last_lines.front(), "80");
  EXPECT_EQ(result.last_lines.back(), "99");
}

TEST(ChildProcess, ASignalGivesAnExitCodeOf128PlusItsNumber) {
  EXPECT_EQ(Shell("kill -9 $$").exit_code, 137);
}

TEST(ChildProcess, ProgramsThatCannotStartAreEnvironmentErrors) {
  EXPECT_THAT(MessageOf<EnvironmentError>([] { RunChild("/nowhere/tool", {}, {}); }),
              HasSubstr("/nowhere/tool"));
  EXPECT_TRUE(FindProgram("there-is-no-such-program").empty());
  EXPECT_TRUE(FindProgram("sh").is_absolute());
}

TEST(ChildProcess, TheTimeLimitEndsAHangingProgram) {
  const Timer timer;
  ChildOptions options;
  options.time_limit_s = 0.3;
  EXPECT_THAT(MessageOf<EnvironmentError>([&] { RunChild(FindProgram("sleep"), {"30"}, options); }),
              HasSubstr("0.3 s"));
  EXPECT_LT(timer.seconds(), 20);
}

// A grandchild in the background keeps the pipe open; only the child's end counts.
TEST(ChildProcess, MemoryIsLimited) {
  const auto exit_code = [](uint64_t limit) {
    ChildOptions options;
    options.max_memory_bytes = limit;
    return RunChild(FindProgram("dd"), {"if=/dev/zero", "of=/dev/null", "bs=300M", "count=1"},
                    options)
        .exit_code;
  };
  EXPECT_EQ(exit_code(0), 0);
  EXPECT_NE(exit_code(uint64_t{200} << 20), 0);
}

TEST(ChildProcess, AGrandchildDoesNotDelayTheResult) {
  const Timer timer;
  EXPECT_EQ(Shell("sleep 30 & exit 5").exit_code, 5);
  EXPECT_LT(timer.seconds(), 20);
}

}  // namespace
}  // namespace tetrec
