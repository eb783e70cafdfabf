// The form of the segment integral that a renderer computes.
#include "render/integral.h"

#include "core/error.h"
#include "shared/integral.glsl.h"

#include <fmt/format.h>

#include <charconv>

namespace tetrec {

static_assert(int(IntegralKind::kExact) == kIntegralExact &&
              int(IntegralKind::kMean) == kIntegralMean &&
              int(IntegralKind::kSplit) == kIntegralSplit);

IntegralOptions ParseIntegral(const std::string& words) {
  const std::string prefix = "split:";
  if (words == "exact") return {IntegralKind::kExact};
  if (words == "mean") return {IntegralKind::kMean};
  if (!words.starts_with(prefix)) {
    throw UsageError(fmt::format("{}: no such integral; use exact, mean or split:N", words));
  }
  IntegralOptions integral{IntegralKind::kSplit};
  std::from_chars(words.data() + prefix.size(), words.data() + words.size(), integral.splits);
  const bool in_range = integral.splits >= 1 && integral.splits <= kMaxSplits;
  if (!in_range || Name(integral) != words) {
    throw UsageError(
        fmt::format("{}: expected a number of parts from 1 to {} after split:", words, kMaxSplits));
  }
  return integral;
}

std::string Name(const IntegralOptions& integral) {
  switch (integral.kind) {
    case IntegralKind::kExact:
      return "exact";
    case IntegralKind::kMean:
      return "mean";
    case IntegralKind::kSplit:
      return fmt::format("split:{}", integral.splits);
  }
  TETREC_CHECK(false, "an integral of no known kind");
}

}  // namespace tetrec
