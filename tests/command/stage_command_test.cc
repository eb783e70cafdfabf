// Stages: command line, key, up to date, resume, foreign folders, failures, signals.
#include "command/stage_command.h"

#include "command/option_checks.h"
#include "core/child_process.h"
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/stage.h"
#include "core/stage_input.h"
#include "core/stop_request.h"
#include "core/timer.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <thread>

namespace tetrec {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

struct Outcome {
  int exit_code = 0;
  bool ran = false;
  bool resumed = false;
  std::string out, err;
};

// Runs a small stage "first" in this process: it copies INPUT to out/copy.txt.
class StageTest : public ::testing::Test {
 protected:
  using Body = std::function<void(Stage&)>;

  static void CopyInput(Stage& stage) {
    WriteText(stage.Output("out/copy.txt"), ReadText(stage.Input("INPUT")));
    WriteText(stage.Scratch("scratch.txt"), "x");
    WriteText(stage.Cache("cached.txt"), "kept");
    stage.Count("files", 1);
  }

  static Outcome RunCommand(StageCommand& command, std::vector<std::string> words,
                            const Body& body) {
    std::vector<char*> argv;
    words.insert(words.begin(), "tetrec");
    for (std::string& word : words) argv.push_back(word.data());
    Outcome outcome;
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    outcome.exit_code = command.Run(int(argv.size()), argv.data(), [&](Stage& stage) {
      outcome.ran = true;
      outcome.resumed = stage.resume();
      body(stage);
    });
    outcome.out = ::testing::internal::GetCapturedStdout();
    outcome.err = ::testing::internal::GetCapturedStderr();
    SetLogFile("");
    TakeWarnings();
    return outcome;
  }

  Outcome First(std::vector<std::string> words, const Body& body = CopyInput, int version = 1) {
    double rate = 0.1;
    std::string device;
    bool fast = false;
    StageCommand command("first", version, "Copies.");
    command.InputPath("INPUT", "A file");
    command.app().add_option("--rate", rate, "Rate [1/s]");
    command.app().add_flag("--fast", fast, "Fast");
    command.DoesNotChangeResults(command.app().add_option("--device", device, "Device"));
    return RunCommand(command, std::move(words), body);
  }

  Outcome Second(const std::string& input, const std::string& output) {
    StageCommand command("second", 1, "Reads.");
    command.InputStage("FIRST", "Folder of first", {"first"});
    return RunCommand(command, {input, "-o", output}, [](Stage& stage) {
      WriteText(stage.Output("n.txt"), ReadText(stage.Input("FIRST") / "out/copy.txt"));
    });
  }

  void SetUp() override { WriteText(input_, "hello"); }

  nlohmann::json Manifest() const { return ReadJson(fs::path(output_) / "manifest.json"); }
  nlohmann::json Status() const { return ReadJson(fs::path(output_) / "status.json"); }

  ScratchFolder folder_;
  const std::string input_ = folder_ / "input.txt", output_ = folder_ / "run/1_first";
};

TEST_F(StageTest, WritesManifestStatusAndLog) {
  const Outcome outcome = First({input_, "-o", output_, "--fast"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const nlohmann::json manifest = Manifest();
  EXPECT_EQ(manifest["schema"], 1);
  EXPECT_EQ(manifest["stage"], "first");
  EXPECT_EQ(manifest["options"]["rate"], 0.1);
  EXPECT_EQ(manifest["options"]["fast"], true);
  EXPECT_EQ(manifest["counts"]["files"], 1);
  ASSERT_EQ(manifest["outputs"].size(), 1u);
  EXPECT_EQ(manifest["outputs"][0]["path"], "out/copy.txt");
  EXPECT_EQ(manifest["outputs"][0]["sha256"], Sha256OfFile(input_));
  EXPECT_EQ(manifest["inputs"][0]["path"], "../../input.txt");
  EXPECT_GT(manifest["peak_rss_bytes"].get<uint64_t>(), 0u);
  EXPECT_EQ(Status()["status"], "done");
  EXPECT_FALSE(fs::exists(fs::path(output_) / "scratch.txt"));
  EXPECT_TRUE(fs::exists(fs::path(output_) / "cached.txt"));
  EXPECT_THAT(ReadText(fs::path(output_) / "log.txt"), HasSubstr("\"fast\":true"));
}

TEST_F(StageTest, HelpExitsWithZeroAndWrongCommandLinesWithTwo) {
  EXPECT_EQ(First({"--help"}).exit_code, 0);
  EXPECT_THAT(First({"--help"}).out, HasSubstr("Rate [1/s]"));
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{},
                                             {input_},
                                             {input_, "-o", output_, "--none"},
                                             {input_, "-o", output_, "--rate", "x"},
                                             {input_, "-o", output_, "--force", "--resume"}}) {
    const Outcome outcome = First(words);
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
  EXPECT_FALSE(fs::exists(output_));
}

TEST_F(StageTest, InvalidAndOutOfRangeNumbersTouchNothing) {
  double rate = 1, share = 1;
  uint64_t steps = 1;
  const auto run = [&](const std::string& name, const std::string& value) {
    StageCommand command("first", 1, "Copies.");
    command.InputPath("INPUT", "A file");
    command.app().add_option("--rate", rate, "Rate [1/s]");
    command.app().add_option("--share", share, "Share")->check(AboveZero());
    command.app().add_option("--room", share, "Room")->check(AtLeastZero());
    command.app().add_option("--steps", steps, "Steps");
    const Outcome outcome = RunCommand(command, {input_, "-o", output_, name, value}, CopyInput);
    EXPECT_EQ(outcome.exit_code == 0, fs::exists(output_)) << name << " " << value;
    fs::remove_all(output_);
    return outcome;
  };
  for (const auto& [name, value] :
       std::vector<std::pair<std::string, std::string>>{{"--rate", "nan"},
                                                        {"--rate", "inf"},
                                                        {"--steps", "-3"},
                                                        {"--share", "0"},
                                                        {"--share", "nan"},
                                                        {"--room", "-1"},
                                                        {"--room", "nan"},
                                                        {"--share", "x"},
                                                        {"--steps", "1e99"},
                                                        {"--steps", "99999999999999999999"},
                                                        {"--rate", "-inf"}}) {
    const Outcome outcome = run(name, value);
    EXPECT_EQ(outcome.exit_code, 2) << name << " " << value;
    EXPECT_THAT(outcome.err, HasSubstr(name));
    EXPECT_THAT(outcome.err, HasSubstr(value));
    EXPECT_LT(outcome.err.size(), 120u) << outcome.err;
  }
  EXPECT_EQ(run("--rate", "-2.5").exit_code, 0);
  EXPECT_EQ(run("--room", "0").exit_code, 0);
  EXPECT_EQ(run("--share", "1e-9").exit_code, 0);
  EXPECT_EQ(run("--steps", "7").exit_code, 0);
}

TEST_F(StageTest, TheSameCommandAgainIsUpToDate) {
  First({input_, "-o", output_});
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{input_, "-o", output_},
                                             {input_, "-o", output_ + "/"},
                                             {input_, "-o", output_, "--rate", "1e-1"},
                                             {input_, "-o", output_, "--device", "other"},
                                             {input_, "-o", output_, "--resume"}}) {
    const Outcome outcome = First(words);
    EXPECT_EQ(outcome.exit_code, 0);
    EXPECT_FALSE(outcome.ran);
    EXPECT_THAT(outcome.out, HasSubstr("up to date"));
  }
}

TEST_F(StageTest, ARefusedRunLeavesTheEarlierResultAsItWas) {
  First({input_, "-o", output_});
  const nlohmann::json manifest = Manifest(), status = Status();
  const auto refuse = [](Stage&) { throw EnvironmentError("no such device"); };
  EXPECT_EQ(First({input_, "-o", output_, "--rate", "3"}, refuse).exit_code, 4);
  EXPECT_EQ(First({input_, "-o", output_, "--force"}, refuse).exit_code, 4);
  EXPECT_EQ(Manifest(), manifest);
  EXPECT_EQ(Status(), status);
  EXPECT_TRUE(fs::exists(fs::path(output_) / "cached.txt"));
  const std::string log = ReadText(fs::path(output_) / "log.txt");
  EXPECT_THAT(log, HasSubstr("no such device"));
  EXPECT_THAT(log, HasSubstr("the earlier result stays as it is"));
  EXPECT_FALSE(First({input_, "-o", output_}).ran);  // up to date

  // A run that was refused after work for later runs keeps both, but not its scratch.
  const auto refuse_later = [](Stage& stage) {
    WriteText(stage.Cache("found.txt"), "found");
    WriteText(stage.Scratch("half.txt"), "half");
    throw DataError("no photos");
  };
  EXPECT_EQ(First({input_, "-o", output_, "--rate", "3"}, refuse_later).exit_code, 3);
  EXPECT_EQ(Manifest(), manifest);
  EXPECT_EQ(Status()["key"], status["key"]);
  EXPECT_EQ(Status()["caches"], nlohmann::json({"cached.txt", "found.txt"}));
  EXPECT_FALSE(fs::exists(fs::path(output_) / "half.txt"));
  EXPECT_FALSE(First({input_, "-o", output_}).ran);

  // A forced run removes earlier caches first.
  const auto refuse_forced = [&](Stage& stage) {
    stage.Scratch("half.txt");
    EXPECT_TRUE(fs::exists(fs::path(output_) / "cached.txt"));
    stage.Cache("found.txt");
    EXPECT_FALSE(fs::exists(fs::path(output_) / "cached.txt"));
    EXPECT_FALSE(fs::exists(fs::path(output_) / "found.txt"));
    throw DataError("no photos");
  };
  EXPECT_EQ(First({input_, "-o", output_, "--force"}, refuse_forced).exit_code, 3);
  EXPECT_EQ(Manifest(), manifest);
  EXPECT_EQ(Status()["caches"], nlohmann::json({"found.txt"}));
  EXPECT_FALSE(First({input_, "-o", output_}).ran);

  // Another run removes it as soon as it writes; the log is then that run's alone.
  const auto fail_later = [&](Stage& stage) {
    EXPECT_TRUE(fs::exists(fs::path(output_) / "out/copy.txt"));
    LogInfo("before the first path");
    stage.Output("other.txt");
    EXPECT_FALSE(fs::exists(fs::path(output_) / "manifest.json"));
    EXPECT_FALSE(fs::exists(fs::path(output_) / "out/copy.txt"));
    throw DataError("too late");
  };
  EXPECT_EQ(First({input_, "-o", output_, "--rate", "4"}, fail_later).exit_code, 3);
  EXPECT_EQ(Status()["status"], "failed");
  EXPECT_EQ(Status()["own"], nlohmann::json({"other.txt"}));
  const std::string later = ReadText(fs::path(output_) / "log.txt");
  EXPECT_THAT(later, HasSubstr("before the first path"));
  EXPECT_THAT(later, HasSubstr("too late"));
  EXPECT_EQ(later.find("no such device"), std::string::npos);
}

TEST_F(StageTest, ScratchStaysWhenTheEarlierResultGoes) {
  First({input_, "-o", output_}, [](Stage& stage) { WriteText(stage.Output("old.txt"), "old"); });
  const fs::path out = output_;
  const auto work = [&](Stage& stage) {
    const fs::path half = stage.Scratch("half.txt");
    WriteText(half, "half");
    EXPECT_TRUE(fs::exists(out / "manifest.json"));
    stage.Output("new.txt");
    EXPECT_FALSE(fs::exists(out / "old.txt"));
    EXPECT_TRUE(fs::exists(half));
    throw Interrupted("stopped");
  };
  EXPECT_EQ(First({input_, "-o", output_, "--fast"}, work).exit_code, 130);
  EXPECT_EQ(Status()["scratch"], nlohmann::json({"half.txt"}));
  const Outcome resumed = First({input_, "-o", output_, "--fast"}, [&](Stage& stage) {
    EXPECT_TRUE(fs::exists(stage.Scratch("half.txt")));
    WriteText(stage.Output("new.txt"), "new");
  });
  EXPECT_TRUE(resumed.resumed);
}

// Their names may be those of files that another version wrote.
TEST_F(StageTest, ScratchAndCachesNeverContainAnEarlierResult) {
  for (const bool cache : {false, true}) {
    First({input_, "-o", output_}, [](Stage& stage) { WriteText(stage.Output("a/b"), "old"); });
    const auto other = [&](Stage& stage) {
      EXPECT_TRUE(fs::exists(fs::path(output_) / "a/b"));
      EXPECT_FALSE(fs::exists(cache ? stage.Cache("a/b") : stage.Scratch("a/b")));
    };
    EXPECT_TRUE(First({input_, "-o", output_}, other, 2 + cache).ran);
  }
}

TEST_F(StageTest, AResultGetsItsStatusBackAfterARunThatWasKilled) {
  First({input_, "-o", output_});
  const nlohmann::json manifest = Manifest(), status = Status();
  // By the command of the result, or by one that is refused.
  for (const bool is_refused : {false, true}) {
    const pid_t pid = fork();
    if (pid == 0) {
      // With other options, or forced.
      const std::string option = is_refused ? "--rate=3" : "--force";
      First({input_, "-o", output_, option}, [](Stage& stage) {
        WriteText(stage.Scratch("half.txt"), "half");
        raise(SIGKILL);
      });
      _exit(0);
    }
    int ended = 0;
    waitpid(pid, &ended, 0);
    ASSERT_TRUE(WIFSIGNALED(ended));
    EXPECT_EQ(Status()["status"], "running");
    EXPECT_TRUE(fs::exists(fs::path(output_) / "half.txt"));
    const auto refuse = [](Stage&) { throw DataError("no photos"); };
    if (is_refused) {
      EXPECT_EQ(First({input_, "-o", output_, "--rate", "4"}, refuse).exit_code, 3);
    } else {
      EXPECT_FALSE(First({input_, "-o", output_}).ran);
    }
    EXPECT_EQ(Manifest(), manifest);
    for (const char* name : {"key", "status", "options", "own"}) {
      EXPECT_EQ(Status()[name], status[name]) << name;
    }
    EXPECT_FALSE(fs::exists(fs::path(output_) / "half.txt"));
  }
  EXPECT_FALSE(First({input_, "-o", output_}).ran);
}

// Its outputs are gone in part, and it is not what the new run has begun.
TEST_F(StageTest, ARunThatWasKilledWhileItRemovedAnotherResultIsNotResumed) {
  First({input_, "-o", output_}, [](Stage& stage) {
    WriteText(stage.Output("a.txt"), "a");
    WriteText(stage.Output("b.txt"), "b");
  });
  nlohmann::json half = Status();
  half["key"] = "";
  WriteJson(fs::path(output_) / "status.json", half);
  fs::remove(fs::path(output_) / "manifest.json");
  fs::remove(fs::path(output_) / "a.txt");
  const Outcome next = First({input_, "-o", output_, "--fast"});
  EXPECT_FALSE(next.resumed);
  EXPECT_FALSE(fs::exists(fs::path(output_) / "b.txt"));
}

TEST_F(StageTest, NothingIsResumedWhereNothingWasBegun) {
  const Outcome outcome = First({input_, "-o", output_, "--resume"});
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_FALSE(outcome.ran);
  EXPECT_THAT(outcome.err, HasSubstr("there is no earlier run in this folder"));
}

TEST_F(StageTest, ChangedOptionsInputsVersionsAndSpoiledOutputsRunAgain) {
  First({input_, "-o", output_});
  EXPECT_TRUE(First({input_, "-o", output_, "--rate", "0.2"}).ran);
  EXPECT_TRUE(First({input_, "-o", output_, "--rate", "0.2", "--fast"}).ran);
  EXPECT_TRUE(First({input_, "-o", output_}).ran);
  EXPECT_TRUE(First({input_, "-o", output_, "--force"}).ran);
  EXPECT_TRUE(First({input_, "-o", output_}, CopyInput, 2).ran);
  WriteText(input_, "other");
  EXPECT_TRUE(First({input_, "-o", output_}).ran);
  EXPECT_FALSE(First({input_, "-o", output_}).ran);
  WriteText(fs::path(output_) / "out/copy.txt", "spoiled by hand");
  const Outcome resumed = First({input_, "-o", output_, "--resume"});
  EXPECT_EQ(resumed.exit_code, 3);
  EXPECT_FALSE(resumed.ran);
  EXPECT_THAT(resumed.err, HasSubstr("was finished, and its output was changed since"));
  EXPECT_TRUE(First({input_, "-o", output_}).ran);
  EXPECT_EQ(ReadText(fs::path(output_) / "out/copy.txt"), "other");
}

TEST_F(StageTest, AnotherRunRemovesTheFilesOfTheFirstButNotTheCacheNorForeignFiles) {
  First({input_, "-o", output_}, [](Stage& stage) {
    WriteText(stage.Output("old/a.txt"), "a");
    WriteText(stage.Cache("cache/b.txt"), "b");
  });
  WriteText(fs::path(output_) / "mine.txt", "the user's own");
  const Outcome outcome = First({input_, "-o", output_, "--fast"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_FALSE(fs::exists(fs::path(output_) / "old"));
  EXPECT_TRUE(fs::exists(fs::path(output_) / "cache/b.txt"));
  EXPECT_TRUE(fs::exists(fs::path(output_) / "mine.txt"));
  First({input_, "-o", output_, "--force"});
  EXPECT_FALSE(fs::exists(fs::path(output_) / "cache/b.txt"));
  EXPECT_TRUE(fs::exists(fs::path(output_) / "mine.txt"));
}

TEST_F(StageTest, ForeignFoldersAndOtherStagesFoldersAreLeftAlone) {
  fs::create_directories(folder_ / "foreign");
  WriteText(folder_ / "foreign/manifest.json", "{\"name\": \"a web page\"}");
  const Outcome foreign = First({input_, "-o", folder_ / "foreign"});
  EXPECT_EQ(foreign.exit_code, 2);
  EXPECT_THAT(foreign.err, HasSubstr("not empty and not a stage folder"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "foreign"), fs::directory_iterator()),
            1);

  First({input_, "-o", output_});
  ASSERT_EQ(Second(output_, folder_ / "run/2_second").exit_code, 0);
  const Outcome wrong = First({input_, "-o", folder_ / "run/2_second"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_THAT(wrong.err, HasSubstr("tetrec-second"));
  EXPECT_EQ(Second(output_, output_).exit_code, 2);
  EXPECT_EQ(Second(output_, output_ + "/inside").exit_code, 2);
  EXPECT_TRUE(fs::exists(folder_ / "run/2_second/manifest.json"));
}

TEST_F(StageTest, WrongMissingAndUnfinishedPreviousStagesAreNamed) {
  const std::string second = folder_ / "run/2_second";
  Outcome outcome = Second(folder_ / "none", second);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("run tetrec-first"));
  outcome = Second(folder_.path(), second);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("not a stage folder"));

  First({input_, "-o", output_}, [](Stage&) { throw DataError("the picture a.jpg is empty"); });
  outcome = Second(output_, second);
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("the picture a.jpg is empty"));

  First({input_, "-o", output_});
  ASSERT_EQ(Second(output_, second).exit_code, 0);
  outcome = Second(second, folder_ / "run/3_second");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("expected the folder that tetrec-first wrote"));
  fs::remove(fs::path(output_) / "out/copy.txt");
  outcome = Second(output_, folder_ / "run/4_second");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("out/copy.txt"));
}

TEST_F(StageTest, AChainIsFollowedOnlyThroughFoldersThatWereNotMadeAnew) {
  const std::string second = folder_ / "run/2_second";
  First({input_, "-o", output_});
  ASSERT_EQ(Second(output_, second).exit_code, 0);
  EXPECT_EQ(PreviousStage(second, {"first"}), fs::canonical(output_));
  // Made again with the same content: nothing changed.
  EXPECT_TRUE(First({input_, "-o", output_, "--force"}).ran);
  EXPECT_EQ(PreviousStage(second, {"first"}), fs::canonical(output_));
  WriteText(input_, "other");
  EXPECT_TRUE(First({input_, "-o", output_}).ran);
  ExpectError<DataError>([&] { PreviousStage(second, {"first"}); },
                         {output_ + ": was recreated since " + second + " was made from it",
                          "run tetrec-second and the stages after it again"});
  ExpectError<DataError>([&] { PreviousStage(output_, {"first"}); },
                         {output_ + ": was not made from a folder of tetrec-first"});
  fs::remove_all(output_);
  ExpectError<DataError>([&] { PreviousStage(second, {"zeroth"}); },
                         {output_ + ": is missing or unfinished, and " + second});
}

TEST_F(StageTest, ALaterStageRunsAgainAlthoughOnlyWhatTheEarlierOneReadHasChanged) {
  const std::string second = folder_ / "run/2_second", third = folder_ / "run/3_third";
  const auto run = [&](const std::string& name, const std::string& before, const std::string& input,
                       const std::string& output) {
    StageCommand command(name, 1, "Writes always the same.");
    command.InputStage("BEFORE", "Folder of the stage before", {before});
    return RunCommand(command, {input, "-o", output},
                      [](Stage& stage) { WriteText(stage.Output("n.txt"), "same"); });
  };
  First({input_, "-o", output_});
  run("second", "first", output_, second);
  run("third", "second", second, third);
  EXPECT_FALSE(run("third", "second", second, third).ran);
  WriteText(input_, "changed");
  First({input_, "-o", output_});
  EXPECT_TRUE(run("second", "first", output_, second).ran);
  ExpectError<DataError>([&] { PreviousStage(third, {"first"}); },
                         {second + ": was recreated since " + third + " was made from it"});
  EXPECT_TRUE(run("third", "second", second, third).ran);
  EXPECT_EQ(PreviousStage(third, {"first"}), fs::canonical(output_));
}

TEST_F(StageTest, AResultOfAVersionThatHashedOutputsAloneIsStillFollowed) {
  const std::string second = folder_ / "run/2_second", third = folder_ / "run/3_third";
  First({input_, "-o", output_});
  Second(output_, second);
  StageCommand command("third", 1, "Reads.");
  command.InputStage("SECOND", "Folder of second", {"second"});
  RunCommand(command, {second, "-o", third},
             [](Stage& stage) { WriteText(stage.Output("n.txt"), "n"); });
  nlohmann::json manifest = ReadJson(fs::path(third) / "manifest.json");
  manifest["inputs"][0]["sha256"] =
      HashOfJson(ReadJson(fs::path(second) / "manifest.json")["outputs"]);
  WriteJson(fs::path(third) / "manifest.json", manifest);
  EXPECT_THROW(PreviousStage(third, {"first"}), DataError);
  manifest.erase("degraded");
  WriteJson(fs::path(third) / "manifest.json", manifest);
  EXPECT_EQ(PreviousStage(third, {"first"}), fs::canonical(output_));
}

TEST_F(StageTest, ADegradedResultIsNotUpToDate) {
  const auto degraded = [](Stage& stage) {
    CopyInput(stage);
    stage.Degrade("no curves: gnuplot is not in PATH");
  };
  EXPECT_THAT(First({input_, "-o", output_}, degraded).err, HasSubstr("warning: no curves"));
  EXPECT_EQ(Manifest()["degraded"][0], "no curves: gnuplot is not in PATH");
  EXPECT_THAT(First({input_, "-o", output_, "--resume"}).out, HasSubstr("up to date"));
  EXPECT_TRUE(First({input_, "-o", output_}).ran);
  EXPECT_TRUE(Manifest()["degraded"].empty());
  EXPECT_FALSE(First({input_, "-o", output_}).ran);
}

TEST_F(StageTest, TheKeyOfALaterStageFollowsTheContentOfTheEarlierOne) {
  const std::string second = folder_ / "run/2_second";
  First({input_, "-o", output_});
  Second(output_, second);
  EXPECT_FALSE(Second(output_, second).ran);
  First({input_, "-o", output_, "--force"});  // the same files again
  EXPECT_FALSE(Second(output_, second).ran);
  WriteText(input_, "changed");
  First({input_, "-o", output_});
  EXPECT_TRUE(Second(output_, second).ran);
  EXPECT_EQ(ReadJson(fs::path(second) / "manifest.json")["previous"], "../1_first");
}

TEST_F(StageTest, FailuresGiveTheirExitCodesAndOneLine) {
  const auto run = [&](const Body& body) { return First({input_, "-o", output_}, body); };
  EXPECT_EQ(run([](Stage&) { throw UsageError("u"); }).exit_code, 2);
  EXPECT_EQ(run([](Stage&) { throw DataError("d"); }).exit_code, 3);
  EXPECT_EQ(run([](Stage&) { throw EnvironmentError("e"); }).exit_code, 4);
  EXPECT_EQ(run([](Stage&) { throw std::bad_alloc(); }).exit_code, 4);
  EXPECT_EQ(run([](Stage&) { TETREC_CHECK(1 > 2, "sums"); }).exit_code, 1);
  const Outcome bug = run([](Stage&) { throw std::logic_error("two\nlines"); });
  EXPECT_EQ(bug.exit_code, 1);
  EXPECT_THAT(bug.err, HasSubstr("bug: two lines"));
  EXPECT_EQ(Status()["status"], "failed");
  EXPECT_FALSE(fs::exists(fs::path(output_) / "manifest.json"));
  // An output that was announced but not written is a bug too.
  EXPECT_EQ(run([](Stage& stage) { stage.Output("never"); }).exit_code, 1);
}

// A folder that somebody else prepared may contain anything.
TEST_F(StageTest, NothingOutsideOfTheFolderIsWrittenOrRemoved) {
  const nlohmann::json status = {{"schema", 1}, {"stage", "first"}, {"key", "x"}};
  const fs::path out = output_, victims = folder_ / "victims";
  const auto lists = [&](const char* role, const char* path) {
    nlohmann::json with = status;
    with[role] = {path};
    return with;
  };
  const std::vector<std::function<void()>> traps = {
      [&] { WriteJson(out / "status.json", lists("scratch", "link/docs")); },
      [&] { WriteJson(out / "status.json", lists("own", "link/docs")); },
      [&] { WriteJson(out / "status.json", lists("caches", "link/docs")); },
      [&] { WriteJson(out / "status.json", lists("scratch", "../../victims")); },
      [&] { fs::create_directory_symlink(victims, out / "out"); },
      [&] { fs::create_symlink(victims / "docs/a", out / "log.txt"); },
      [&] { fs::create_symlink(victims / "docs/a", out / "scratch.txt"); },
      [&] { fs::create_symlink(victims / "docs/a", out / "status.json.tmp"); },
      [&] { fs::create_symlink(victims / "docs/a", out / "manifest.json.tmp"); },
      [&] {
        fs::remove(out / ".lock");
        fs::create_symlink(victims / "docs/a", out / ".lock");
      },
      [&] {
        fs::remove(out / ".lock");
        fs::create_hard_link(victims / "docs/a", out / ".lock");
      },
      [&] { mkfifo((out / "log.txt").c_str(), 0600); },
      [&] { mkfifo((out / "out").c_str(), 0600); }};
  for (size_t i = 0; i < traps.size(); ++i) {
    for (const char* force : {"--rate=0.2", "--force"}) {
      fs::remove_all(out);
      fs::create_directories(victims / "docs");
      WriteText(victims / "docs/a", "mine");
      ASSERT_EQ(First({input_, "-o", output_}).exit_code, 0);
      fs::remove(out / "log.txt");
      fs::remove_all(out / "out");
      if (i < 3) fs::create_directory_symlink(victims, out / "link");
      traps[i]();
      const Outcome outcome = First({input_, "-o", output_, force});
      EXPECT_TRUE(outcome.exit_code == 0 || outcome.exit_code == 2) << i << outcome.err;
      EXPECT_EQ(ReadText(victims / "docs/a"), "mine") << i;
      EXPECT_EQ(std::distance(fs::directory_iterator(victims), {}), 1) << i;
      EXPECT_EQ(std::distance(fs::directory_iterator(victims / "docs"), {}), 1) << i;
    }
  }
}

// Those of a stage that was killed.
TEST_F(StageTest, LinksInScratchAndCachesAreRemoved) {
  WriteText(folder_ / "photo", "mine");
  const Body killed = [&](Stage& stage) {
    for (const fs::path& place : {stage.Scratch("work"), stage.Cache("cache")}) {
      fs::create_directories(place / "photos");
      fs::create_symlink(folder_ / "photo", place / "photos/0.jpg");
    }
    throw Interrupted("stopped");
  };
  EXPECT_EQ(First({input_, "-o", output_}, killed).exit_code, 130);
  const Outcome again = First({input_, "-o", output_}, [&](Stage& stage) {
    EXPECT_FALSE(fs::exists(stage.Scratch("work") / "photos/0.jpg"));
    EXPECT_FALSE(fs::exists(stage.Cache("cache") / "photos/0.jpg"));
  });
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(ReadText(folder_ / "photo"), "mine");
}

TEST_F(StageTest, DamageOfEqualSizeIsNoticed) {
  const fs::path copy = fs::path(output_) / "out/copy.txt";
  First({input_, "-o", output_});
  ASSERT_EQ(Second(output_, folder_ / "run/2_second").exit_code, 0);
  WriteText(copy, "jello");
  const Outcome outcome = Second(output_, folder_ / "run/2_second");
  EXPECT_EQ(outcome.exit_code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("out/copy.txt is missing or was changed"));
  EXPECT_THAT(outcome.err, HasSubstr("run tetrec-first again"));
  EXPECT_TRUE(First({input_, "-o", output_}).ran);
  EXPECT_EQ(ReadText(copy), "hello");
  EXPECT_EQ(Second(output_, folder_ / "run/2_second").exit_code, 0);
}

TEST_F(StageTest, AFileOfAStageFolderLeadsToTheFolder) {
  First({input_, "-o", output_});
  const Outcome inside = Second(output_ + "/manifest.json", folder_ / "run/2_second");
  EXPECT_EQ(inside.exit_code, 3);
  EXPECT_THAT(inside.err, HasSubstr("is a file; give the folder that it is in: " + output_));
  const Outcome other = Second(input_, folder_ / "run/2_second");
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_THAT(other.err, HasSubstr("is a file; expected the folder that tetrec-first wrote"));
}

TEST_F(StageTest, PathsThatCannotBeStoredAreRefusedAndShownEscaped) {
  for (const char* name : {"Gr\xf6\xdf"
                           "e",
                           "a\nb", "\x1b[2J"}) {
    const std::string input = folder_.Write(name, "hello");
    for (const Outcome& outcome : {First({input, "-o", output_}),
                                   First({input_, "-o", folder_ / ("run/" + std::string(name))})}) {
      EXPECT_EQ(outcome.exit_code, 2);
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
      EXPECT_EQ(outcome.err.find('\x1b'), std::string::npos);
      EXPECT_THAT(outcome.err, HasSubstr("rename it"));
    }
  }
  EXPECT_FALSE(fs::exists(folder_ / "run"));
}

TEST_F(StageTest, TheFolderThatOneIsInCanBeTheOutput) {
  const fs::path before = fs::current_path();
  fs::create_directories(folder_ / "above/here");
  fs::current_path(folder_ / "above/here");
  const Outcome here = First({input_, "-o", "."});
  const Outcome above = First({input_, "-o", ".."});
  fs::current_path(before);
  EXPECT_EQ(here.exit_code, 0) << here.err;
  EXPECT_TRUE(fs::exists(folder_ / "above/here/manifest.json"));
  EXPECT_THAT(above.err, HasSubstr(".. is not empty"));
  EXPECT_FALSE(fs::exists(folder_ / "above/manifest.json"));
}

TEST_F(StageTest, PathsThatTheSystemRefusesGiveOneLine) {
  const std::string name(300, 'x');
  fs::create_symlink("loop", folder_ / "loop");
  for (const std::string path :
       {folder_ / name, folder_ / "loop", std::filesystem::path(input_ + "/below")}) {
    const Outcome outcome = First({path, "-o", output_});
    EXPECT_TRUE(outcome.exit_code == 2 || outcome.exit_code == 3) << outcome.err;
    EXPECT_EQ(outcome.err.find("filesystem error"), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

// If both were followed, 40 levels of these links would give 2^40 names.
TEST_F(StageTest, LinksThatLeadBackAreNotFollowed) {
  folder_.Write("photos/a.jpg", "x");
  fs::create_directory_symlink(".", folder_ / "photos/self");
  fs::create_directory_symlink("../photos", folder_ / "photos/again");
  EXPECT_EQ(First({folder_ / "photos", "-o", output_}, [](Stage&) {}).exit_code, 0);
}

TEST_F(StageTest, AMissingInputOrAnUnwritableOutputTouchesNothing) {
  EXPECT_EQ(First({folder_ / "none", "-o", output_}).exit_code, 3);
  EXPECT_FALSE(fs::exists(output_));
  EXPECT_EQ(First({input_, "-o", input_ + "/sub"}).exit_code, 4);
}

TEST_F(StageTest, AnInterruptedRunContinuesWithTheSameCommandAndStartsOverWithAnother) {
  const Body interrupted = [](Stage& stage) {
    WriteText(stage.Scratch("half"), "half");
    throw Interrupted("stopped; a checkpoint is kept");
  };
  EXPECT_EQ(First({input_, "-o", output_}, interrupted).exit_code, 130);
  EXPECT_EQ(Status()["status"], "interrupted");

  const Outcome other = First({input_, "-o", output_, "--rate", "3", "--resume"});
  EXPECT_EQ(other.exit_code, 3);
  EXPECT_FALSE(other.ran);
  EXPECT_THAT(other.err, HasSubstr("rate (was 0.1, now 3"));
  EXPECT_TRUE(fs::exists(fs::path(output_) / "half"));

  const Outcome resumed = First({input_, "-o", output_, "--resume"});
  EXPECT_EQ(resumed.exit_code, 0);
  EXPECT_TRUE(resumed.resumed);
  EXPECT_FALSE(fs::exists(fs::path(output_) / "half"));

  First({input_, "-o", output_, "--force"}, interrupted);
  const Outcome fresh = First({input_, "-o", output_, "--rate", "3"}, [&](Stage& stage) {
    EXPECT_FALSE(fs::exists(fs::path(output_) / "half"));
    CopyInput(stage);
  });
  EXPECT_EQ(fresh.exit_code, 0);
  EXPECT_FALSE(fresh.resumed);
}

// Signals end a process, so these runs happen in a child process of the test.
class StageSignalTest : public StageTest {
 protected:
  // Starts the stage with a body that waits until it is asked to stop, and returns once it runs.
  pid_t StartWaitingRun(bool ignores_stop = false) {
    const pid_t pid = fork();
    if (pid == 0) {
      const Outcome outcome = First({input_, "-o", output_}, [&](Stage& stage) {
        WriteText(stage.Scratch("running"), "");
        for (int i = 0; i < 1000; ++i) {
          if (!ignores_stop) ThrowIfStopRequested("nothing lost");
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
      });
      _exit(outcome.exit_code);
    }
    for (int i = 0; i < 1000 && !fs::exists(fs::path(output_) / "running"); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return pid;
  }
  static int WaitFor(pid_t pid) {
    int status = 0;
    waitpid(pid, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }
};

TEST_F(StageSignalTest, SigtermAndSigintEndWith130AndTheRunCanBeContinued) {
  for (const int number : {SIGTERM, SIGINT}) {
    const pid_t pid = StartWaitingRun();
    kill(pid, number);
    EXPECT_EQ(WaitFor(pid), 130);
    EXPECT_EQ(Status()["status"], "interrupted");
    EXPECT_TRUE(First({input_, "-o", output_}).resumed);
    First({input_, "-o", output_, "--force"}, [](Stage& stage) {
      stage.Output("clear");
      throw DataError("clear");
    });
  }
}

TEST_F(StageSignalTest, AStopAfterTheLastOfTheWorkKeepsTheResult) {
  const pid_t pid = fork();
  if (pid == 0) {
    const Outcome outcome = First({input_, "-o", output_}, [](Stage& stage) {
      CopyInput(stage);
      raise(SIGINT);
    });
    _exit(outcome.exit_code);
  }
  EXPECT_EQ(WaitFor(pid), 130);
  EXPECT_EQ(Status()["status"], "done");
  const Outcome again = First({input_, "-o", output_});
  EXPECT_FALSE(again.ran);
  EXPECT_THAT(again.out, HasSubstr("up to date"));
}

TEST_F(StageSignalTest, ASecondSignalEndsAtOnce) {
  const pid_t pid = StartWaitingRun(true);
  kill(pid, SIGTERM);
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  kill(pid, SIGTERM);
  EXPECT_EQ(WaitFor(pid), 130);
}

TEST_F(StageSignalTest, AKilledRunIsReportedAndCanBeContinued) {
  const pid_t pid = StartWaitingRun();
  EXPECT_THAT(Second(output_, folder_ / "run/2_second").err,
              HasSubstr("still running there; wait until it has finished"));
  const Outcome busy = First({input_, "-o", output_});
  EXPECT_EQ(busy.exit_code, 4);
  EXPECT_THAT(busy.err, HasSubstr(std::to_string(pid)));
  EXPECT_FALSE(busy.ran);
  kill(pid, SIGKILL);
  EXPECT_EQ(WaitFor(pid), 137);
  EXPECT_EQ(Status()["status"], "running");
  EXPECT_THAT(Second(output_, folder_ / "run/2_second").err, HasSubstr("killed"));
  const Outcome resumed = First({input_, "-o", output_});
  EXPECT_EQ(resumed.exit_code, 0);
  EXPECT_TRUE(resumed.resumed);
}

TEST_F(StageTest, ARunIsRunningWhileItsFolderIsLocked) {
  // Process 1 is always alive, so a recorded process id does not show that this run is.
  First({input_, "-o", output_}, [](Stage& stage) { stage.Scratch("work"); });
  nlohmann::json status = Status();
  status.update({{"status", "running"}, {"pid", 1}});
  WriteJson(fs::path(output_) / "status.json", status);
  fs::remove(fs::path(output_) / "manifest.json");
  EXPECT_THAT(Second(output_, folder_ / "run/2_second").err, HasSubstr("killed"));
}

TEST_F(StageSignalTest, AChildProcessStopsWithItsStage) {
  const pid_t pid = fork();
  if (pid == 0) {
    const Outcome outcome = First({input_, "-o", output_}, [&](Stage& stage) {
      WriteText(stage.Scratch("running"), "");
      RunChild(FindProgram("sleep"), {"60"}, {});
    });
    _exit(outcome.exit_code);
  }
  for (int i = 0; i < 1000 && !fs::exists(fs::path(output_) / "running"); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const Timer timer;
  kill(pid, SIGTERM);
  EXPECT_EQ(WaitFor(pid), 130);
  EXPECT_LT(timer.seconds(), 30);
}

}  // namespace
}  // namespace tetrec
