// Exhaustive matching of SIFT descriptors: all dot products, tile by tile.
#include "scene/colmap_matching.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "core/error.h"

namespace tetrec {
namespace internal {
namespace {

void Offer(BestTwo& two, int32_t dot, int32_t index) {
  if (dot > two.best) {
    two.second = two.best;
    two.best = dot;
    two.index = index;
  } else if (dot > two.second) {
    two.second = dot;
  }
}

size_t RowsOf(std::span<const uint8_t> descriptors) {
  TETREC_CHECK(descriptors.size() % kDescriptorBytes == 0, "a descriptor is cut");
  return descriptors.size() / kDescriptorBytes;
}

}  // namespace

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

#if defined(__x86_64__)
namespace {

// A tile is kTileRows descriptors of the first picture by kTileColumns of the second; its dot
// products stay in registers. Descriptors are widened to 16 bits, two neighbouring entries to one
// 32-bit lane.
constexpr size_t kTileRows = 4, kLanes = 8, kTileColumns = 2 * kLanes;
constexpr size_t kSteps = kDescriptorBytes / 2;

size_t RoundUp(size_t value, size_t step) { return (value + step - 1) / step * step; }

// Two neighbouring entries of a descriptor as one lane; 0 behind the last descriptor.
int32_t PairOfEntries(std::span<const uint8_t> descriptors, size_t row, size_t step) {
  const size_t at = row * kDescriptorBytes + 2 * step;
  if (at >= descriptors.size()) return 0;
  return int32_t(descriptors[at]) | int32_t(descriptors[at + 1]) << 16;
}

// Blocks of `block` rows; inside a block step by step, so that the kernel reads straight on.
std::vector<int32_t> Interleave(std::span<const uint8_t> descriptors, size_t block) {
  const size_t rows = RoundUp(RowsOf(descriptors), block);
  std::vector<int32_t> lanes;
  lanes.reserve(rows * kSteps);
  for (size_t start = 0; start < rows; start += block) {
    for (size_t step = 0; step < kSteps; ++step) {
      for (size_t row = start; row < start + block; ++row) {
        lanes.push_back(PairOfEntries(descriptors, row, step));
      }
    }
  }
  return lanes;
}

// Eight BestTwo side by side, in memory: vector types do not belong in containers.
struct BestTwoLanes {
  int32_t best[kLanes] = {}, second[kLanes] = {};
  int32_t index[kLanes] = {-1, -1, -1, -1, -1, -1, -1, -1};
};

__attribute__((target("avx2"), always_inline)) inline void OfferLanes(BestTwoLanes& lanes,
                                                                      __m256i dots,
                                                                      __m256i indices) {
  auto* best = reinterpret_cast<__m256i*>(lanes.best);
  auto* second = reinterpret_cast<__m256i*>(lanes.second);
  auto* index = reinterpret_cast<__m256i*>(lanes.index);
  const __m256i old = _mm256_loadu_si256(best), better = _mm256_cmpgt_epi32(dots, old);
  const __m256i loser = _mm256_min_epi32(old, dots);
  _mm256_storeu_si256(second, _mm256_max_epi32(_mm256_loadu_si256(second), loser));
  _mm256_storeu_si256(best, _mm256_max_epi32(old, dots));
  _mm256_storeu_si256(index, _mm256_blendv_epi8(_mm256_loadu_si256(index), indices, better));
}

__attribute__((target("avx2"), always_inline)) inline void DotTile(const int32_t* rows,
                                                                   const int32_t* columns,
                                                                   __m256i (&dots)[kTileRows][2]) {
  for (auto& row : dots) row[0] = row[1] = _mm256_setzero_si256();
  for (size_t step = 0; step < kSteps; ++step) {
    const auto* c = reinterpret_cast<const __m256i*>(columns + step * kTileColumns);
    const __m256i c0 = _mm256_loadu_si256(c), c1 = _mm256_loadu_si256(c + 1);
    for (size_t r = 0; r < kTileRows; ++r) {
      const __m256i entry = _mm256_set1_epi32(rows[step * kTileRows + r]);
      dots[r][0] = _mm256_add_epi32(dots[r][0], _mm256_madd_epi16(entry, c0));
      dots[r][1] = _mm256_add_epi32(dots[r][1], _mm256_madd_epi16(entry, c1));
    }
  }
}

// The best two of eight lanes; of equals the one with the lower index.
BestTwo Reduce(const BestTwoLanes& lanes) {
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

__attribute__((target("avx2"))) BestOfPair FindBestAvx2(std::span<const uint8_t> first,
                                                        std::span<const uint8_t> second) {
  const std::vector<int32_t> rows = Interleave(first, kTileRows);
  const std::vector<int32_t> columns = Interleave(second, kTileColumns);
  const size_t row_count = rows.size() / kSteps, column_count = columns.size() / kSteps;
  const __m256i count_up = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  std::vector<BestTwoLanes> of_column(column_count / kLanes);

  BestOfPair result;
  for (size_t row = 0; row < row_count; row += kTileRows) {
    BestTwoLanes of_row[kTileRows];
    for (size_t column = 0; column < column_count; column += kTileColumns) {
      __m256i dots[kTileRows][2];
      DotTile(&rows[row * kSteps], &columns[column * kSteps], dots);
      for (size_t half = 0; half < 2; ++half) {
        const __m256i column_ids =
            _mm256_add_epi32(_mm256_set1_epi32(int32_t(column + half * kLanes)), count_up);
        BestTwoLanes& below = of_column[column / kLanes + half];
        for (size_t r = 0; r < kTileRows; ++r) {
          OfferLanes(of_row[r], dots[r][half], column_ids);
          OfferLanes(below, dots[r][half], _mm256_set1_epi32(int32_t(row + r)));
        }
      }
    }
    for (const BestTwoLanes& lanes : of_row) result.of_first.push_back(Reduce(lanes));
  }
  for (const BestTwoLanes& lanes : of_column) {
    for (size_t lane = 0; lane < kLanes; ++lane) {
      result.of_second.push_back({lanes.best[lane], lanes.second[lane], lanes.index[lane]});
    }
  }
  // The rows that fill up the last tiles are all 0 and never win.
  result.of_first.resize(RowsOf(first));
  result.of_second.resize(RowsOf(second));
  return result;
}

}  // namespace
#endif

BestOfPair FindBest(std::span<const uint8_t> first, std::span<const uint8_t> second) {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) return FindBestAvx2(first, second);
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
