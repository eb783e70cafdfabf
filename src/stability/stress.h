// The stress test: every case beside its clean twin, and a verdict.
#pragma once

#include "core/words.h"
#include "stability/chain.h"
#include "stability/stress_cases.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

enum class Verdict {
  kClean,    // a twin that others are compared with
  kHolds,    // loses no more than kLargestLoss_db
  kExcused,  // loses more, because information is gone
  kRefused,  // the input was refused with a message for the user, exit code 3
  kBreaks,   // loses more without need, has degenerate tets, failed otherwise or took too long; or
             // a clean case from which nothing was learned
  kSkipped,  // does not apply to the scene, or its twin failed
};
template <>
inline constexpr auto kWords<Verdict> =
    std::to_array<Word<Verdict>>({{Verdict::kClean, "clean"},
                                  {Verdict::kHolds, "holds"},
                                  {Verdict::kExcused, "information gone"},
                                  {Verdict::kRefused, "refused"},
                                  {Verdict::kBreaks, "breaks"},
                                  {Verdict::kSkipped, "skipped"}});

inline constexpr double kLargestLoss_db = 3;
inline constexpr double kLeastOfClean_db = 12;  // with less, nothing was learned

struct StressOptions {
  std::filesystem::path scene;     // folder of the first stage; empty: a synthetic room
  std::filesystem::path programs;  // folder of the stages
  std::vector<std::string> cases;  // names; empty: all
  uint64_t iterations = 0;         // steps of a run; 0: 400, or 60 in the short form
  uint64_t seed = 1;               // of the scene and its damages
  bool is_short = false;           // few cases on a scene of 32x32 px

  // Throws UsageError naming the option and its value: a case that does not exist.
  void Check() const;
  uint64_t Steps() const;
};

struct StressResult {
  std::string name, what, twin, gone;  // of the case
  ChainResult run;
  std::optional<double> lost_db;  // against the twin
  Verdict verdict = Verdict::kSkipped;
};

// What the run of a case is worth; `twin` is null for a clean case.
Verdict Judge(const ChainResult& run, const ChainResult* twin, bool information_is_gone);

// Writes runs below `out`; what is up to date there is not run again. Prints a line per case.
std::vector<StressResult> RunStress(const StressOptions& options, const std::filesystem::path& out);

}  // namespace tetrec
