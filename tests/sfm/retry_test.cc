// The second try for photos that stayed out: pure decisions.
#include "sfm/retry.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

namespace tetrec {
namespace {

using ::testing::Contains;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Not;

std::vector<uint32_t> Photos(uint32_t count) {
  std::vector<uint32_t> ids(count);
  std::iota(ids.begin(), ids.end(), 1u);
  return ids;
}

TEST(ConcernedPhotos, AreTheMissingOneItsNeighboursAndItsBestPartners) {
  std::map<ImagePair, uint64_t> matches;
  for (uint32_t id = 1; id <= 50; ++id) {
    if (id != 10) matches[{std::min(10u, id), std::max(10u, id)}] = id >= 40 ? 100 + id : 5;
  }
  matches[{20, 30}] = 1000;  // concerns others
  const auto concerned = ConcernedPhotos(Photos(50), {10}, matches);
  EXPECT_THAT(concerned,
              ElementsAre(7, 8, 9, 10, 11, 12, 13, 41, 42, 43, 44, 45, 46, 47, 48, 49, 50));
}

TEST(ConcernedPhotos, AtTheEndsAndWithoutMatchesOnlyNeighboursAreAdded) {
  EXPECT_THAT(ConcernedPhotos(Photos(20), {1}, {}), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(ConcernedPhotos(Photos(20), {20}, {{{5, 20}, 0}}), ElementsAre(17, 18, 19, 20));
}

TEST(ConcernedPhotos, AreAllIfNoneIsRegistered) {
  EXPECT_EQ(ConcernedPhotos(Photos(4), {1, 2, 3, 4}, {}), Photos(4));
}

TEST(PairsOfRetry, AreThoseOfConcernedPhotosAndOfTheMissingWithAll) {
  EXPECT_THAT(PairsOfRetry(Photos(5), {2, 3, 4}, {3}),
              ElementsAre(ImagePair(1, 3), ImagePair(2, 3), ImagePair(2, 4), ImagePair(3, 4),
                          ImagePair(3, 5)));
}

ColmapModel ModelOf(uint32_t images, double error_px) {
  ColmapModel model;
  for (uint32_t i = 0; i < images; ++i) model.images[i].name = fmt::format("{}.jpg", i);
  if (images > 0) model.points[0].error_px = error_px;
  return model;
}

TEST(IsBetterModel, AsksForMorePhotosAtASaneError) {
  EXPECT_TRUE(IsBetterModel(ModelOf(20, 0.6), ModelOf(24, 0.7)));
  EXPECT_TRUE(IsBetterModel(ModelOf(20, 1.2), ModelOf(24, 1.4)));
  EXPECT_FALSE(IsBetterModel(ModelOf(20, 0.6), ModelOf(24, 1.3)));
  EXPECT_FALSE(IsBetterModel(ModelOf(20, 0.6), ModelOf(20, 0.1)));
  EXPECT_FALSE(IsBetterModel(ModelOf(20, 0.6), ModelOf(0, 0)));
  EXPECT_TRUE(IsBetterModel(ModelOf(0, 0), ModelOf(5, 2)));
}

}  // namespace
}  // namespace tetrec
