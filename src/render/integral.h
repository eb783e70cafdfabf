// The form of the segment integral that a renderer computes (shaders/shared/integral.glsl.h).
#pragma once

#include <string>

namespace tetrec {

// In the order of kIntegralExact, kIntegralMean, kIntegralSplit of the shared header.
enum class IntegralKind {
  kExact,  // linear density, linear colour
  kMean,   // exact opacity; colour by the segment's mean density
  kSplit,  // kMean in each of several equal parts
};

constexpr int kMaxSplits = 64;

struct IntegralOptions {
  IntegralKind kind = IntegralKind::kExact;
  int splits = 1;  // 1 .. kMaxSplits parts of a segment, for kSplit
};

// "exact", "mean", or "split:N". Throws UsageError.
IntegralOptions ParseIntegral(const std::string& words);

// The words for an integral.
std::string Name(const IntegralOptions& integral);

}  // namespace tetrec
