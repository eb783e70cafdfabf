// Parallel loops and progress numbers.
#include "core/parallel.h"

#include "core/error.h"
#include "core/progress.h"
#include "core/stop_request.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

namespace tetrec {
namespace {

TEST(ParallelFor, VisitsEveryIndexOnce) {
  for (const size_t count : {0, 1, 7, 1000}) {
    for (const size_t grain : {0, 1, 3, 2000}) {
      std::vector<std::atomic<int>> visits(count);
      ParallelFor(count, grain, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) ++visits[i];
      });
      for (const auto& n : visits) EXPECT_EQ(n, 1);
    }
  }
}

TEST(ParallelFor, RangesDependOnCountAndGrainOnly) {
  ParallelFor(10, 4, [](size_t begin, size_t end) {
    EXPECT_EQ(begin % 4, 0u);
    EXPECT_EQ(end, std::min<size_t>(begin + 4, 10));
  });
}

// In a process of its own, whose user may not start another thread. It ends without the handlers of
// exit, among which the leak checker of the sanitizer build would start one.
TEST(ParallelForDeathTest, DoesAllWorkWhereTheSystemStartsNoThreads) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto limited = [] {
    if (geteuid() == 0 && setresuid(65534, 65534, 65534) != 0) std::_Exit(1);
    const rlimit none{1, 1};
    if (setrlimit(RLIMIT_NPROC, &none) != 0) std::_Exit(2);
    try {
      std::thread([] {}).join();
      std::fputs("threads start in spite of the limit", stderr);
      std::_Exit(7);
    } catch (const std::system_error&) {
    }
    std::atomic<int> visits = 0;
    ParallelFor(1000, 1, [&](size_t, size_t) { ++visits; });
    std::fprintf(stderr, "%d visits", visits.load());
    std::_Exit(7);
  };
  EXPECT_EXIT(limited(), testing::ExitedWithCode(7), "1000 visits");
}

TEST(ParallelFor, RethrowsWhatABodyThrows) {
  EXPECT_THROW(ParallelFor(100, 1,
                           [](size_t i, size_t) {
                             if (i == 37) throw std::range_error("37");
                           }),
               std::range_error);
}

TEST(ParallelForEach, VisitsEveryIndexOnceAndRethrows) {
  for (const size_t count : {0, 1, 100}) {
    std::vector<std::atomic<int>> visits(count);
    ParallelForEach(count, "", "nothing is kept", [&](size_t i) { ++visits[i]; });
    for (const auto& n : visits) EXPECT_EQ(n, 1);
  }
  const auto fail = [](size_t i) {
    if (i == 37) throw std::range_error("37");
  };
  EXPECT_THROW(ParallelForEach(100, "", "nothing is kept", fail), std::range_error);
}

// In a process of its own, because a request to stop cannot be taken back.
TEST(ParallelForEachDeathTest, StartsNothingAfterARequestToStopAndStatesWhatIsKept) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto stopped = [] {
    CatchStopSignals();
    std::atomic<int> calls = 0;
    try {
      ParallelForEach(100000, "", "the pages are kept", [&](size_t i) {
        ++calls;
        if (i == 10) std::raise(SIGTERM);
      });
    } catch (const Interrupted& interrupted) {
      std::fprintf(stderr, "%s %s", interrupted.what(), calls < 100000 ? "early" : "late");
      std::exit(7);
    }
  };
  EXPECT_EXIT(stopped(), testing::ExitedWithCode(7), "the pages are kept early");
}

TEST(Progress, TheTimeLeftIsShownOnceItCanBeKnown) {
  EXPECT_EQ(ProgressLine("render", 0, 7, 0, ""), "render 0/7 (0 %)  0:00");
  EXPECT_EQ(ProgressLine("render", 1, 7, 0.5, ""), "render 1/7 (14 %)  0:01") << "too early";
  EXPECT_EQ(ProgressLine("pairs", 4, 1000, 60, ""), "pairs 4/1,000 (0 %)  1:00") << "too little";
  EXPECT_EQ(ProgressLine("pairs", 250, 1000, 60, "x"),
            "pairs 250/1,000 (25 %)  1:00, 3:00 left  x");
  EXPECT_EQ(ProgressLine("pairs", 1000, 1000, 60, ""), "pairs 1,000/1,000 (100 %)  1:00");
  EXPECT_EQ(ProgressLine("optimise", 0.25, Progress::kShare, 30, "loss 0.1"),
            "optimise 25 %  0:30, 1:30 left  loss 0.1");
  EXPECT_EQ(ProgressLine("steps", 12345, 0, 90, ""), "steps 12,345  1:30") << "no end is known";
}

TEST(Progress, NumbersAndTimesAreReadable) {
  EXPECT_EQ(WithThousands(0), "0");
  EXPECT_EQ(WithThousands(999), "999");
  EXPECT_EQ(WithThousands(1234567), "1,234,567");
  EXPECT_EQ(AsDuration(65), "1:05");
  EXPECT_EQ(AsDuration(7390), "2:03:10");
  EXPECT_EQ(AsDuration(-1), "?");
}

}  // namespace
}  // namespace tetrec
