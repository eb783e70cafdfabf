// The DiffTetVR article's figure of hyperparameters: rates of colours and of positions, weight and
// sharpness of the regulariser of quality, by the article's motion of vertices, by ours and without
// any.
#pragma once

#include "core/words.h"
#include "stability/chain.h"

#include <cstdint>
#include <filesystem>
#include <vector>

namespace tetrec {

enum class SweptParameter {
  kColorRate,     // Adam's first step on colours and on density's parameter
  kPositionRate,  // first step of positions, as a share of the subject's longest side
  kWeight,        // lambda
  kSharpness,     // beta
};
template <>
inline constexpr auto kWords<SweptParameter> =
    std::to_array<Word<SweptParameter>>({{SweptParameter::kColorRate, "color-rate"},
                                         {SweptParameter::kPositionRate, "position-rate"},
                                         {SweptParameter::kWeight, "quality-weight"},
                                         {SweptParameter::kSharpness, "quality-sharpness"}});

enum class SweptMethod { kFixed, kSafe, kArticle };
template <>
inline constexpr auto kWords<SweptMethod> =
    std::to_array<Word<SweptMethod>>({{SweptMethod::kFixed, "vertices fixed"},
                                      {SweptMethod::kSafe, "safe motion"},
                                      {SweptMethod::kArticle, "article's motion"}});

struct SweepOptions {
  std::filesystem::path scene;     // folder of the first stage; empty: two synthetic balls
  std::filesystem::path programs;  // folder of the stages
  uint64_t iterations = 0;         // steps of a run; 0: 300, or 40 in the short form
  uint64_t seed = 1;
  bool is_short = false;  // one value of each parameter, on a scene of 32x32 px

  uint64_t Steps() const;
  int GridCells() const;  // of the start, along the subject's longest side
};

struct SweepResult {
  SweptParameter parameter = SweptParameter::kColorRate;
  SweptMethod method = SweptMethod::kFixed;
  double value = 0;  // of the parameter
  ChainResult run;

  // Failed, or has degenerate tets.
  bool IsBroken() const;
};

// Safe motion may lose this much against fixed vertices.
inline constexpr double kLargestSweepLoss_db = 1;

// The runs of safe motion that are broken or lose more than kLargestSweepLoss_db against fixed
// vertices at the same colour rate.
std::vector<SweepResult> UnsafeRuns(const std::vector<SweepResult>& results);

// Writes runs below `out`; what is up to date there is not run again. Prints a line per run. Fixed
// vertices know no parameter but the colour rate, so they run once for all others.
std::vector<SweepResult> RunSweep(const SweepOptions& options, const std::filesystem::path& out);

}  // namespace tetrec
