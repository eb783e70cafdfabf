// The device's radix sort and prefix sums against the standard library's.
#include "render/vulkan/radix_sort.h"

#include "vulkan_test.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace tetrec::test {
namespace {

struct Pair {
  uint32_t key, item;
  bool operator==(const Pair&) const = default;
};

// Items are the places of the keys, which reveals a sort that is not stable.
std::vector<Pair> SortOnDevice(const Device& device, const std::vector<uint32_t>& keys, int bits) {
  std::vector<uint32_t> items(keys.size());
  std::iota(items.begin(), items.end(), 0u);
  SortList list;
  list.Reserve(device, keys.size());
  list.keys.Upload(keys);
  list.items.Upload(items);
  RadixSort sort(device);
  sort.Reserve(keys.size());
  CommandRecorder recorder(device);
  recorder.Begin();
  sort.Record(recorder, list, uint32_t(keys.size()), bits);
  recorder.EndAndSubmit();
  recorder.Wait();
  const auto sorted_keys = list.keys.DownloadAs<uint32_t>(keys.size());
  const auto sorted_items = list.items.DownloadAs<uint32_t>(keys.size());
  std::vector<Pair> pairs;
  for (size_t i = 0; i < keys.size(); ++i) pairs.push_back({sorted_keys[i], sorted_items[i]});
  return pairs;
}

std::vector<Pair> SortOnHost(const std::vector<uint32_t>& keys, int bits) {
  const uint32_t mask = bits == 32 ? 0xFFFFFFFFu : (1u << bits) - 1u;
  std::vector<Pair> pairs;
  for (uint32_t i = 0; i < keys.size(); ++i) pairs.push_back({keys[i], i});
  std::stable_sort(pairs.begin(), pairs.end(), [mask](const Pair& a, const Pair& b) {
    return (a.key & mask) < (b.key & mask);
  });
  return pairs;
}

std::vector<uint32_t> RandomWords(size_t count, uint32_t most, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<uint32_t> word(0, most);
  std::vector<uint32_t> words(count);
  for (uint32_t& value : words) value = word(random);
  return words;
}

class RadixSortTest : public VulkanTest {};

TEST_F(RadixSortTest, SortsAsTheStandardLibraryForEverySize) {
  // Sizes around the runs of 256 keys and of 64 counters, powers of two, odd sizes.
  for (size_t count : {0, 1, 2, 63, 64, 255, 256, 257, 4096, 5001, 65536, 100003}) {
    for (uint32_t most : {0xFFFFFFFFu, 100u, 0u}) {
      const std::vector<uint32_t> keys = RandomWords(count, most, uint32_t(count) + 1);
      ASSERT_EQ(SortOnDevice(device(), keys, 32), SortOnHost(keys, 32)) << count << " " << most;
    }
  }
}

TEST_F(RadixSortTest, SortsTwoMillionKeys) {
  const std::vector<uint32_t> keys = RandomWords(2'000'000, 0xFFFFFFFFu, 7);
  EXPECT_EQ(SortOnDevice(device(), keys, 32), SortOnHost(keys, 32));
}

TEST_F(RadixSortTest, SortsByTheLowestDigitsAlone) {
  const std::vector<uint32_t> keys = RandomWords(3000, 0xFFFFFFFFu, 9);
  for (int bits : {0, 8, 16, 24}) {
    EXPECT_EQ(SortOnDevice(device(), keys, bits), SortOnHost(keys, bits)) << bits;
  }
}

TEST_F(RadixSortTest, PrefixSumsAreThoseOfTheStandardLibrary) {
  for (size_t count : {1, 64, 65, 4096, 4097, 300001}) {
    const std::vector<uint32_t> values = RandomWords(count, 1000, uint32_t(count));
    std::vector<uint32_t> truth(count);
    std::exclusive_scan(values.begin(), values.end(), truth.begin(), 0u);
    const Buffer buffer = MakeBuffer(device(), "values", values);
    PrefixSum sum(device());
    sum.Reserve(count);
    CommandRecorder recorder(device());
    recorder.Begin();
    sum.Record(recorder, buffer, uint32_t(count));
    recorder.EndAndSubmit();
    recorder.Wait();
    EXPECT_EQ(buffer.DownloadAs<uint32_t>(count), truth) << count;
  }
}

}  // namespace
}  // namespace tetrec::test
