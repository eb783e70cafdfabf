// The search for the best descriptors with AVX-512 VNNI. Its dot products multiply unsigned by
// signed bytes, so the entries of the first image are lowered by 128; the sums of the second
// image's entries correct this exactly.
#include "colmap/match_lanes.h"

#if defined(__x86_64__)
#include <immintrin.h>

#ifndef __clang__
// GCC 12 warns of the deliberately undefined operand inside its own intrinsics.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

namespace tetrec::internal {
namespace {

#define TETREC_VNNI target("avx512f,avx512bw,avx512vnni")

// A tile is kTileRows descriptors of the first image by kTileColumns of the second; its dot
// products stay in registers. Four neighbouring entries make one 32-bit lane.
constexpr size_t kTileRows = 4, kLanes = 16, kTileVectors = 4, kTileColumns = kTileVectors * kLanes;
constexpr size_t kSteps = kDescriptorBytes / 4;
// All rows are processed with this many columns, which stay in the first-level cache (16 KiB).
constexpr size_t kBlockColumns = 128;
using Lanes = BestTwoLanes<kLanes>;

// Four neighbouring entries of a descriptor as one lane; 0 after the last descriptor.
uint32_t FourEntries(std::span<const uint8_t> descriptors, size_t row, size_t step) {
  const size_t at = row * kDescriptorBytes + 4 * step;
  uint32_t lane = 0;
  if (at < descriptors.size()) std::memcpy(&lane, &descriptors[at], sizeof(lane));
  return lane;
}

// Blocks of `block` rows, each ordered step by step, so that the kernel reads consecutive memory.
// The bits of `flip` are flipped in every lane.
std::vector<uint32_t> Interleave(std::span<const uint8_t> descriptors, size_t block,
                                 uint32_t flip) {
  const size_t rows = RoundUp(RowsOf(descriptors), block);
  std::vector<uint32_t> lanes;
  lanes.reserve(rows * kSteps);
  for (size_t start = 0; start < rows; start += block) {
    for (size_t step = 0; step < kSteps; ++step) {
      for (size_t row = start; row < start + block; ++row) {
        lanes.push_back(FourEntries(descriptors, row, step) ^ flip);
      }
    }
  }
  return lanes;
}

// 128 times the sum of each descriptor's entries; 0 for descriptors that pad the last tile.
std::vector<int32_t> Corrections(std::span<const uint8_t> descriptors) {
  std::vector<int32_t> sums(RoundUp(RowsOf(descriptors), kTileColumns), 0);
  for (size_t i = 0; i < descriptors.size(); ++i)
    sums[i / kDescriptorBytes] += 128 * descriptors[i];
  return sums;
}

__attribute__((TETREC_VNNI, always_inline)) inline void OfferLanes(Lanes& lanes, __m512i dots,
                                                                   __m512i indices) {
  // Rarely is any of them among the best two.
  const __m512i second = _mm512_loadu_si512(lanes.second);
  if (_mm512_cmpgt_epi32_mask(dots, second) == 0) return;
  const __m512i old = _mm512_loadu_si512(lanes.best);
  const __mmask16 better = _mm512_cmpgt_epi32_mask(dots, old);
  const __m512i loser = _mm512_min_epi32(old, dots);
  _mm512_storeu_si512(lanes.second, _mm512_max_epi32(second, loser));
  _mm512_storeu_si512(lanes.best, _mm512_max_epi32(old, dots));
  _mm512_mask_storeu_epi32(lanes.index, better, indices);
}

// The sums are a local array and all loops over it are unrolled: only then do they stay in
// registers.
__attribute__((TETREC_VNNI, always_inline)) inline void DotTile(
    const uint32_t* rows, const uint32_t* columns, const int32_t* corrections,
    __m512i (&dots)[kTileRows][kTileVectors]) {
  __m512i sums[kTileRows][kTileVectors];
#pragma GCC unroll 4
  for (size_t k = 0; k < kTileVectors; ++k) {
#pragma GCC unroll 4
    for (size_t r = 0; r < kTileRows; ++r)
      sums[r][k] = _mm512_loadu_si512(corrections + k * kLanes);
  }
#pragma GCC unroll 1
  for (size_t step = 0; step < kSteps; ++step) {
    __m512i entries[kTileVectors];
#pragma GCC unroll 4
    for (size_t k = 0; k < kTileVectors; ++k) {
      entries[k] = _mm512_loadu_si512(columns + step * kTileColumns + k * kLanes);
    }
#pragma GCC unroll 4
    for (size_t r = 0; r < kTileRows; ++r) {
      const __m512i lowered = _mm512_set1_epi32(int32_t(rows[step * kTileRows + r]));
#pragma GCC unroll 4
      for (size_t k = 0; k < kTileVectors; ++k) {
        sums[r][k] = _mm512_dpbusd_epi32(sums[r][k], entries[k], lowered);
      }
    }
  }
#pragma GCC unroll 4
  for (size_t r = 0; r < kTileRows; ++r) {
#pragma GCC unroll 4
    for (size_t k = 0; k < kTileVectors; ++k) dots[r][k] = sums[r][k];
  }
}

}  // namespace

bool CanMatchByVnni() {
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
         __builtin_cpu_supports("avx512vnni");
}

__attribute__((TETREC_VNNI)) BestOfPair FindBestVnni(std::span<const uint8_t> first,
                                                     std::span<const uint8_t> second) {
  const std::vector<uint32_t> rows = Interleave(first, kTileRows, 0x80808080u);
  const std::vector<uint32_t> columns = Interleave(second, kTileColumns, 0);
  const std::vector<int32_t> corrections = Corrections(second);
  const size_t row_count = rows.size() / kSteps, column_count = columns.size() / kSteps;
  const __m512i count_up = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  std::vector<Lanes> of_row(row_count), of_column(column_count / kLanes);
  for (size_t first_column = 0; first_column < column_count; first_column += kBlockColumns) {
    const size_t end_column = std::min(first_column + kBlockColumns, column_count);
    for (size_t row = 0; row < row_count; row += kTileRows) {
      for (size_t column = first_column; column < end_column; column += kTileColumns) {
        __m512i dots[kTileRows][kTileVectors];
        DotTile(&rows[row * kSteps], &columns[column * kSteps], &corrections[column], dots);
        for (size_t k = 0; k < kTileVectors; ++k) {
          const __m512i column_ids =
              _mm512_add_epi32(_mm512_set1_epi32(int32_t(column + k * kLanes)), count_up);
          Lanes& below = of_column[column / kLanes + k];
          for (size_t r = 0; r < kTileRows; ++r) {
            OfferLanes(of_row[row + r], dots[r][k], column_ids);
            OfferLanes(below, dots[r][k], _mm512_set1_epi32(int32_t(row + r)));
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
