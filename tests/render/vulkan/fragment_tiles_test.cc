// Tiles cover a batch once and fit.
#include "render/vulkan/fragment_tiles.h"

#include <gtest/gtest.h>

#include <random>

namespace tetrec::test {
namespace {

TEST(FragmentTiles, CoverEveryPixelOnceAndFit) {
  std::mt19937 random(1);
  for (uint64_t capacity : {9u, 30u, 200u, 5000u}) {
    constexpr uint32_t kWidth = 24, kHeight = 14;
    std::vector<uint32_t> counts(kWidth * kHeight);
    for (uint32_t& count : counts) count = uint32_t(random() % 10);
    const auto tiles = CutIntoTiles(kWidth, kHeight, capacity,
                                    [&](uint32_t x, uint32_t y) { return counts[y * kWidth + x]; });
    std::vector<int> covered(counts.size());
    for (const FragmentTile& tile : tiles) {
      uint64_t sum = 0;
      uint32_t longest = 0;
      for (uint32_t y = tile.y; y < tile.y + tile.height; ++y) {
        for (uint32_t x = tile.x; x < tile.x + tile.width; ++x) {
          ++covered[y * kWidth + x];
          sum += counts[y * kWidth + x];
          longest = std::max(longest, counts[y * kWidth + x]);
        }
      }
      EXPECT_EQ(sum, tile.fragments);
      EXPECT_EQ(longest, tile.longest_list);
      EXPECT_LE(sum, capacity);
    }
    EXPECT_EQ(covered, std::vector<int>(counts.size(), 1));
  }
}

TEST(FragmentTiles, AreOneWhereAllFits) {
  const auto tiles = CutIntoTiles(8, 6, 48, [](uint32_t, uint32_t) { return 1u; });
  ASSERT_EQ(tiles.size(), 1u);
  EXPECT_EQ(tiles[0].fragments, 48u);
}

TEST(FragmentTiles, ExceedTheCapacityOnlyInSinglePixels) {
  const auto tiles =
      CutIntoTiles(4, 2, 10, [](uint32_t x, uint32_t y) { return x == 2 && y == 1 ? 11u : 4u; });
  for (const FragmentTile& tile : tiles) {
    if (tile.fragments > 10) {
      EXPECT_EQ(tile.x, 2u);
      EXPECT_EQ(tile.y, 1u);
      EXPECT_EQ(tile.width * tile.height, 1u);
    }
  }
}

}  // namespace
}  // namespace tetrec::test
