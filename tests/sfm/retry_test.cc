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

TEST(LikelyPairsOfRetry, AreThoseOfTheMissingWithTheirPartnersAndOfConcernedPhotosThatSeeTheSame) {
  const std::map<ImagePair, uint64_t> matches = {{{1, 10}, 50}, {{10, 90}, 0}, {{1, 80}, 40}};
  const std::vector<uint32_t> concerned = ConcernedPhotos(Photos(100), {10}, matches);
  EXPECT_THAT(concerned, ElementsAre(1, 7, 8, 9, 10, 11, 12, 13));
  EXPECT_THAT(LikelyPairsOfRetry(Photos(100), concerned, {10}, matches, {{1, 7}, {1, 80}, {8, 9}}),
              ElementsAre(ImagePair(1, 7), ImagePair(1, 10), ImagePair(7, 10), ImagePair(8, 9),
                          ImagePair(8, 10), ImagePair(9, 10), ImagePair(10, 11), ImagePair(10, 12),
                          ImagePair(10, 13)));
}

TEST(LikelyPairsOfRetry, AreNoMoreThanTheFirstTimeWhereManyPhotosAreMissing) {
  std::map<ImagePair, uint64_t> matches;
  std::set<ImagePair> related;
  for (uint32_t id = 1; id <= 500; ++id) {
    for (uint32_t step = 1; step <= 20 && id + step <= 500; ++step) {
      matches[{id, id + step}] = 100 - step;
      related.insert({id, id + step});
    }
  }
  std::set<uint32_t> missing;
  for (uint32_t id = 5; id <= 500; id += 5) missing.insert(id);
  const std::vector<uint32_t> concerned = ConcernedPhotos(Photos(500), missing, matches);
  EXPECT_EQ(concerned.size(), 500u);
  EXPECT_GT(PairsOfRetry(Photos(500), concerned, missing).size(), 10 * matches.size());
  EXPECT_LE(LikelyPairsOfRetry(Photos(500), concerned, missing, matches, related).size(),
            matches.size());
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
