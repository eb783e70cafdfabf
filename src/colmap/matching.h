// Exhaustive matching of SIFT descriptors by COLMAP's rule, but exact and reproducible: COLMAP's
// own CPU matcher is approximate, not reproducible and ten times slower.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

constexpr size_t kDescriptorBytes = 128;

// N descriptors, row by row (N x 128); COLMAP scales them to the length 512.
using Descriptors = std::vector<uint8_t>;

struct FeatureMatch {
  uint32_t first, second;  // rows
  bool operator==(const FeatureMatch&) const = default;
};

struct MatchOptions {
  double max_angle = 0.7;  // [rad] between matched descriptors
  double max_ratio = 0.8;  // angle of the best over angle of the second best
};

// Pairs that are each other's best match and pass both tests in both directions, ordered by
// `first`. Among equals the lowest row is the best. (Rule: Lowe 2004 and COLMAP,
// feature/matching.cc.)
std::vector<FeatureMatch> MatchDescriptors(std::span<const uint8_t> first,
                                           std::span<const uint8_t> second,
                                           const MatchOptions& options = {});

namespace internal {

// Best and second-best dot product of one descriptor with all descriptors of the other image.
struct BestTwo {
  int32_t best = 0, second = 0;
  int32_t index = -1;  // of the best; -1: no dot product is above 0
  bool operator==(const BestTwo&) const = default;
};
struct BestOfPair {
  std::vector<BestTwo> of_first, of_second;
};

// The same result computed in two ways: in plain C++, and with the widest vector instructions that
// the processor supports (match_avx2.cc, match_vnni.cc).
BestOfPair FindBestPlain(std::span<const uint8_t> first, std::span<const uint8_t> second);
BestOfPair FindBest(std::span<const uint8_t> first, std::span<const uint8_t> second);

}  // namespace internal
}  // namespace tetrec
