// Prefix sums and a stable radix sort on the device.
#pragma once

#include "gpu/commands.h"

#include <cstdint>
#include <vector>

namespace tetrec {

// Buffers grow in Reserve, while the device must not be using them; recording takes no memory.
class PrefixSum {
 public:
  explicit PrefixSum(const Device& device);
  void Reserve(uint64_t count);
  // Records commands that replace each of `count` u32 values by the sum (mod 2^32) of those before
  // it.
  void Record(CommandRecorder& recorder, const Buffer& values, uint32_t count);

 private:
  const Device& device_;
  Program sums_, apply_;
  std::vector<Buffer> levels_;  // totals of runs, of runs of runs, ...
};

// u32 keys, each with a u32 item.
struct SortList {
  Buffer keys, items;
  Buffer other_keys, other_items;  // scratch

  // Makes room for at least `count`; the contents are lost if it grows.
  void Reserve(const Device& device, uint64_t count);
};

class RadixSort {
 public:
  explicit RadixSort(const Device& device);
  void Reserve(uint64_t count);
  // Records commands that sort the first `count` keys with their items by the `bits` lowest bits,
  // rounded up to whole bytes, 8 bits per pass. Equal keys keep their order.
  void Record(CommandRecorder& recorder, SortList& list, uint32_t count, int bits);

 private:
  const Device& device_;
  Program count_, scatter_;
  PrefixSum prefix_sum_;
  Buffer digit_counts_;
};

// Sets the first `count` u32 values to 0.
class ZeroFill {
 public:
  explicit ZeroFill(const Device& device);
  void Record(CommandRecorder& recorder, const Buffer& values, uint64_t count);

 private:
  Program program_;
};

}  // namespace tetrec
