// Shared parts of the searches for the best descriptors: the best two so far for one descriptor, or
// for as many descriptors as a vector has lanes.
#pragma once

#include "colmap/matching.h"
#include "core/error.h"

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
  TETREC_CHECK(descriptors.size() % kDescriptorBytes == 0, "a descriptor is incomplete");
  return descriptors.size() / kDescriptorBytes;
}

inline size_t RoundUp(size_t value, size_t step) { return (value + step - 1) / step * step; }

// BestTwo of several descriptors side by side. Plain arrays, since vector types do not belong in
// containers.
template <size_t kLanes>
struct BestTwoLanes {
  int32_t best[kLanes] = {}, second[kLanes] = {};
  int32_t index[kLanes];
  BestTwoLanes() { std::fill_n(index, kLanes, -1); }
};

// The best two over all lanes; among equals the one with the lowest index.
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

// One descriptor per lane.
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

// Drops the descriptors that pad the last tiles; they are 0 and never win.
inline void CutToSize(BestOfPair& best, std::span<const uint8_t> first,
                      std::span<const uint8_t> second) {
  best.of_first.resize(RowsOf(first));
  best.of_second.resize(RowsOf(second));
}

// The tile loops of both look alike but are not shared: functions for one instruction set are not
// inlined into templates for another.
#if defined(__x86_64__)
bool CanMatchByAvx2();
BestOfPair FindBestAvx2(std::span<const uint8_t> first, std::span<const uint8_t> second);
bool CanMatchByVnni();
BestOfPair FindBestVnni(std::span<const uint8_t> first, std::span<const uint8_t> second);
#endif

}  // namespace tetrec::internal
