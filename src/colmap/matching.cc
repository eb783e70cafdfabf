// Exhaustive matching of SIFT descriptors: the plain search, and the pairs that pass.
#include "colmap/matching.h"

#include "colmap/match_lanes.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace internal {
BestOfPair FindBestPlain(std::span<const uint8_t> first, std::span<const uint8_t> second) {
  BestOfPair result;
  result.of_first.resize(RowsOf(first));
  result.of_second.resize(RowsOf(second));
  for (size_t i = 0; i < result.of_first.size(); ++i) {
    for (size_t j = 0; j < result.of_second.size(); ++j) {
      int32_t dot = 0;
      for (size_t k = 0; k < kDescriptorBytes; ++k) {
        dot += int32_t(first[i * kDescriptorBytes + k]) * second[j * kDescriptorBytes + k];
      }
      Offer(result.of_first[i], dot, int32_t(j));
      Offer(result.of_second[j], dot, int32_t(i));
    }
  }
  return result;
}

BestOfPair FindBest(std::span<const uint8_t> first, std::span<const uint8_t> second) {
#if defined(__x86_64__)
  if (CanMatchByVnni()) return FindBestVnni(first, second);
  if (CanMatchByAvx2()) return FindBestAvx2(first, second);
#endif
  return FindBestPlain(first, second);
}

}  // namespace internal

namespace {

double AngleOfDot(int32_t dot) {
  constexpr double kSquaredLength = 512.0 * 512.0;
  return std::acos(std::min(dot / kSquaredLength, 1.0));
}

bool Passes(const internal::BestTwo& two, const MatchOptions& options) {
  if (two.index < 0) return false;
  const double angle = AngleOfDot(two.best);
  return angle <= options.max_angle && angle < options.max_ratio * AngleOfDot(two.second);
}

}  // namespace

std::vector<FeatureMatch> MatchDescriptors(std::span<const uint8_t> first,
                                           std::span<const uint8_t> second,
                                           const MatchOptions& options) {
  const internal::BestOfPair best = internal::FindBest(first, second);
  std::vector<FeatureMatch> matches;
  for (size_t i = 0; i < best.of_first.size(); ++i) {
    const internal::BestTwo& forth = best.of_first[i];
    if (!Passes(forth, options)) continue;
    const internal::BestTwo& back = best.of_second[size_t(forth.index)];
    if (back.index == int32_t(i) && Passes(back, options))
      matches.push_back({uint32_t(i), uint32_t(forth.index)});
  }
  return matches;
}

}  // namespace tetrec
