// The search for the best descriptors with AVX2.
#include "colmap/match_lanes.h"

#if defined(__x86_64__)
#include <immintrin.h>

namespace tetrec::internal {
namespace {

// A tile is kTileRows descriptors of the first image by kTileColumns of the second; its dot
// products stay in registers. Descriptors are widened to 16 bits, two neighbouring entries to one
// 32-bit lane.
constexpr size_t kTileRows = 4, kLanes = 8, kTileColumns = 2 * kLanes;
constexpr size_t kSteps = kDescriptorBytes / 2;
// All rows are processed with this many columns, which stay in the first-level cache (16 KiB).
constexpr size_t kBlockColumns = 64;

// Two neighbouring entries of a descriptor as one lane; 0 after the last descriptor.
int32_t PairOfEntries(std::span<const uint8_t> descriptors, size_t row, size_t step) {
  const size_t at = row * kDescriptorBytes + 2 * step;
  if (at >= descriptors.size()) return 0;
  return int32_t(descriptors[at]) | int32_t(descriptors[at + 1]) << 16;
}

// Blocks of `block` rows, each ordered step by step, so that the kernel reads consecutive memory.
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

using Lanes = BestTwoLanes<kLanes>;

__attribute__((target("avx2"), always_inline)) inline void OfferLanes(Lanes& lanes, __m256i dots,
                                                                      __m256i indices) {
  auto* best = reinterpret_cast<__m256i*>(lanes.best);
  auto* second = reinterpret_cast<__m256i*>(lanes.second);
  auto* index = reinterpret_cast<__m256i*>(lanes.index);
  // Rarely is any of them among the best two.
  const __m256i old_second = _mm256_loadu_si256(second);
  if (_mm256_testz_si256(_mm256_cmpgt_epi32(dots, old_second), _mm256_set1_epi32(-1)) != 0) return;
  const __m256i old = _mm256_loadu_si256(best), better = _mm256_cmpgt_epi32(dots, old);
  const __m256i loser = _mm256_min_epi32(old, dots);
  _mm256_storeu_si256(second, _mm256_max_epi32(old_second, loser));
  _mm256_storeu_si256(best, _mm256_max_epi32(old, dots));
  _mm256_storeu_si256(index, _mm256_blendv_epi8(_mm256_loadu_si256(index), indices, better));
}

// The sums are a local array and all loops over it are unrolled: only then do they stay in
// registers.
__attribute__((target("avx2"), always_inline)) inline void DotTile(const int32_t* rows,
                                                                   const int32_t* columns,
                                                                   __m256i (&dots)[kTileRows][2]) {
  __m256i sums[kTileRows][2];
#pragma GCC unroll 4
  for (auto& row : sums) row[0] = row[1] = _mm256_setzero_si256();
#pragma GCC unroll 1
  for (size_t step = 0; step < kSteps; ++step) {
    const auto* c = reinterpret_cast<const __m256i*>(columns + step * kTileColumns);
    const __m256i c0 = _mm256_loadu_si256(c), c1 = _mm256_loadu_si256(c + 1);
#pragma GCC unroll 4
    for (size_t r = 0; r < kTileRows; ++r) {
      const __m256i entry = _mm256_set1_epi32(rows[step * kTileRows + r]);
      sums[r][0] = _mm256_add_epi32(sums[r][0], _mm256_madd_epi16(entry, c0));
      sums[r][1] = _mm256_add_epi32(sums[r][1], _mm256_madd_epi16(entry, c1));
    }
  }
#pragma GCC unroll 4
  for (size_t r = 0; r < kTileRows; ++r) {
    dots[r][0] = sums[r][0];
    dots[r][1] = sums[r][1];
  }
}

}  // namespace

bool CanMatchByAvx2() { return __builtin_cpu_supports("avx2"); }

__attribute__((target("avx2"))) BestOfPair FindBestAvx2(std::span<const uint8_t> first,
                                                        std::span<const uint8_t> second) {
  const std::vector<int32_t> rows = Interleave(first, kTileRows);
  const std::vector<int32_t> columns = Interleave(second, kTileColumns);
  const size_t row_count = rows.size() / kSteps, column_count = columns.size() / kSteps;
  const __m256i count_up = _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7);
  std::vector<Lanes> of_row(row_count), of_column(column_count / kLanes);
  for (size_t first_column = 0; first_column < column_count; first_column += kBlockColumns) {
    const size_t end_column = std::min(first_column + kBlockColumns, column_count);
    for (size_t row = 0; row < row_count; row += kTileRows) {
      for (size_t column = first_column; column < end_column; column += kTileColumns) {
        __m256i dots[kTileRows][2];
        DotTile(&rows[row * kSteps], &columns[column * kSteps], dots);
        for (size_t half = 0; half < 2; ++half) {
          const __m256i column_ids =
              _mm256_add_epi32(_mm256_set1_epi32(int32_t(column + half * kLanes)), count_up);
          Lanes& below = of_column[column / kLanes + half];
          for (size_t r = 0; r < kTileRows; ++r) {
            OfferLanes(of_row[row + r], dots[r][half], column_ids);
            OfferLanes(below, dots[r][half], _mm256_set1_epi32(int32_t(row + r)));
          }
        }
      }
    }
  }
  BestOfPair result;
  for (const Lanes& lanes : of_row) result.of_first.push_back(Reduce(lanes));
  result.of_second = Unpack(of_column);
  CutToSize(result, first, second);
  return result;
}

}  // namespace tetrec::internal
#endif
