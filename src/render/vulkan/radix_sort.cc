// Prefix sums and a stable radix sort on the device.
//
// Every thread owns a run of values. That keeps the sort stable without shared memory or barriers,
// which are slow on lavapipe; one counter per digit and run amounts to one word per key.
#include "render/vulkan/radix_sort.h"

#include "core/error.h"
#include "embedded_shaders.h"
#include "shared/gpu_types.glsl.h"

#include <algorithm>
#include <utility>

namespace tetrec {
namespace {

using gpu_types::ScanPush;
using gpu_types::SortPush;

uint64_t Runs(uint64_t count, uint64_t run) { return (count + run - 1) / run; }

}  // namespace

PrefixSum::PrefixSum(const Device& device)
    : device_(device),
      sums_(device, "scan_sums", kScanSums),
      apply_(device, "scan_apply", kScanApply) {}

void PrefixSum::Reserve(uint64_t count) {
  size_t level = 0;
  do {
    count = Runs(count, kScanRun);
    if (levels_.size() == level) levels_.emplace_back();
    Grow(device_, levels_[level++], "prefix sums", 4ull * count);
  } while (count > 1);
}

void PrefixSum::Record(CommandRecorder& recorder, const Buffer& values, uint32_t count) {
  // Up: totals of runs until one run contains all; down: every run starts at the total before it.
  std::vector<std::pair<const Buffer*, uint32_t>> levels = {{&values, count}};
  while (levels.back().second > kScanRun) {
    const auto [below, size] = levels.back();
    const uint32_t runs = uint32_t(Runs(size, kScanRun));
    const Buffer& above = levels_.at(levels.size() - 1);
    TETREC_CHECK(above.bytes() >= 4ull * runs, "prefix sums: too little reserved");
    recorder.Dispatch(sums_, {{kBindValues, *below}, {kBindSums, above}}, ScanPush{.count = size},
                      runs);
    levels.emplace_back(&above, runs);
  }
  for (size_t i = levels.size(); i-- > 0;) {
    const auto [buffer, size] = levels[i];
    const bool has_sums = i + 1 < levels.size();
    // If there are none, any other buffer can take their place: it is not read.
    const Buffer& sums = has_sums ? *levels[i + 1].first : levels_.at(i);
    recorder.Dispatch(apply_, {{kBindValues, *buffer}, {kBindSums, sums}},
                      ScanPush{.count = size, .has_sums = has_sums}, Runs(size, kScanRun));
  }
}

void SortList::Reserve(const Device& device, uint64_t count) {
  Grow(device, keys, "sort keys", 4ull * count);
  Grow(device, items, "sort items", 4ull * count);
  Grow(device, other_keys, "other sort keys", 4ull * count);
  Grow(device, other_items, "other sort items", 4ull * count);
}

RadixSort::RadixSort(const Device& device)
    : device_(device),
      count_(device, "sort_count", kSortCount),
      scatter_(device, "sort_scatter", kSortScatter),
      prefix_sum_(device) {}

void RadixSort::Reserve(uint64_t count) {
  const uint64_t counters = Runs(count, kSortRun) * kSortDigits;
  Grow(device_, digit_counts_, "digit counts", 4ull * counters);
  prefix_sum_.Reserve(counters);
}

void RadixSort::Record(CommandRecorder& recorder, SortList& list, uint32_t count, int bits) {
  const uint32_t runs = uint32_t(Runs(count, kSortRun));
  TETREC_CHECK(digit_counts_.bytes() >= 4ull * runs * kSortDigits, "sort: too little reserved");
  for (int shift = 0; shift < bits; shift += 8) {
    const SortPush push{.count = count, .shift = uint32_t(shift), .runs = runs};
    recorder.Dispatch(count_, {{kBindKeys, list.keys}, {kBindDigitCounts, digit_counts_}}, push,
                      runs);
    prefix_sum_.Record(recorder, digit_counts_, runs * kSortDigits);
    recorder.Dispatch(scatter_,
                      {{kBindKeys, list.keys},
                       {kBindItems, list.items},
                       {kBindSortedKeys, list.other_keys},
                       {kBindSortedItems, list.other_items},
                       {kBindDigitCounts, digit_counts_}},
                      push, runs);
    std::swap(list.keys, list.other_keys);
    std::swap(list.items, list.other_items);
  }
}

ZeroFill::ZeroFill(const Device& device) : program_(device, "zero", kZero) {}

void ZeroFill::Record(CommandRecorder& recorder, const Buffer& values, uint64_t count) {
  recorder.Dispatch(program_, {{kBindValues, values}}, ScanPush{.count = uint32_t(count)}, count);
}

}  // namespace tetrec
