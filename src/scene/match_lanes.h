// What the searches for the best descriptors share: the best two so far, of one descriptor or of as
// many as a vector has lanes.
#pragma once

#include "core/error.h"
#include "scene/colmap_matching.h"

#include <algorithm>
#include <cstring>

namespace tetrec::internal {

inline void Offer(BestTwo& two, int32_t dot, int32_t index) {
  if (dot > two.best) {
    two.second = two.best;
    two.best = dot;
    two.index = index;
  } else if (dot > two.second) {
    two.second = dot;
  }
}

inline size_t RowsOf(std::span<const uint8_t> descriptors) {
  TETREC_CHECK(descriptors.size() % kDescriptorBytes == 0, "a descriptor is cut");
  return descriptors.size() / kDescriptorBytes;
}

inline size_t RoundUp(size_t value, size_t step) { return (value + step - 1) / step * step; }

// BestTwo of several descriptors side by side, in memory: vector types do not belong in containers.
template <size_t kLanes>
struct BestTwoLanes {
  int32_t best[kLanes] = {}, second[kLanes] = {};
  int32_t index[kLanes];
  BestTwoLanes() { std::fill_n(index, kLanes, -1); }
};

// The best two of all lanes; of equals the one with the lower index.
template <size_t kLanes>
BestTwo Reduce(const BestTwoLanes<kLanes>& lanes) {
  BestTwo two;
  for (size_t lane = 0; lane < kLanes; ++lane) {
    const int32_t best = lanes.best[lane], index = lanes.index[lane];
    const bool first_of_equals = best == two.best && index >= 0 && index < two.index;
    Offer(two, best, index);
    if (first_of_equals) two.index = index;
    two.second = std::max(two.second, lanes.second[lane]);
  }
  return two;
}

// Each lane its own descriptor.
template <size_t kLanes>
std::vector<BestTwo> Unpack(const std::vector<BestTwoLanes<kLanes>>& all) {
  std::vector<BestTwo> unpacked;
  for (const BestTwoLanes<kLanes>& lanes : all) {
    for (size_t lane = 0; lane < kLanes; ++lane) {
      unpacked.push_back({lanes.best[lane], lanes.second[lane], lanes.index[lane]});
    }
  }
  return unpacked;
}

// Drops the descriptors that filled up the last tiles; all 0, they never won.
inline void CutToSize(BestOfPair& best, std::span<const uint8_t> first,
                      std::span<const uint8_t> second) {
  best.of_first.resize(RowsOf(first));
  best.of_second.resize(RowsOf(second));
}

// The tile loops of both are alike, and apart all the same: functions of one instruction set are
// not inlined into templates of another.
#if defined(__x86_64__)
bool CanMatchByAvx2();
BestOfPair FindBestAvx2(std::span<const uint8_t> first, std::span<const uint8_t> second);
bool CanMatchByVnni();
BestOfPair FindBestVnni(std::span<const uint8_t> first, std::span<const uint8_t> second);
#endif

}  // namespace tetrec::internal
