// Which pairs of images are matched.
#include "colmap/pairs.h"

#include "core/parallel.h"

#include <algorithm>
#include <set>

namespace tetrec {
namespace {

constexpr int kSequentialOverlap = 10;   // neighbours on each side; COLMAP's default
constexpr size_t kCoarseFeatures = 300;  // per image, for the choice of pairs
constexpr size_t kCoarsePartners = 20;   // pairs that each image may choose
constexpr size_t kMinCoarseMatches = 4;

std::vector<ImagePair> AllPairs(const std::vector<DatabaseImage>& images) {
  std::vector<ImagePair> pairs;
  for (size_t i = 0; i < images.size(); ++i) {
    for (size_t k = i + 1; k < images.size(); ++k) pairs.push_back({images[i].id, images[k].id});
  }
  return pairs;
}

// Neighbours within the overlap, and those at distances of powers of two, which tie longer
// stretches together.
void AddSequentialPairs(const std::vector<DatabaseImage>& images, std::set<ImagePair>& pairs) {
  for (size_t i = 0; i < images.size(); ++i) {
    for (int k = 0; k < kSequentialOverlap; ++k) {
      for (const size_t step : {size_t(k) + 1, size_t{1} << k}) {
        if (i + step < images.size()) pairs.insert({images[i].id, images[i + step].id});
      }
    }
  }
}

// Adds for each image the partners with which it has the most matches of coarsest features.
void AddCoarsePairs(const ColmapDatabase& database, const std::vector<DatabaseImage>& images,
                    std::set<ImagePair>& pairs) {
  std::vector<Descriptors> coarse;
  for (const DatabaseImage& image : images)
    coarse.push_back(database.ReadCoarsestDescriptors(image.id, kCoarseFeatures));
  std::vector<std::vector<size_t>> counts(images.size(), std::vector<size_t>(images.size(), 0));
  ParallelFor(images.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      for (size_t k = i + 1; k < images.size(); ++k)
        counts[i][k] = MatchDescriptors(coarse[i], coarse[k]).size();
    }
  });
  for (size_t i = 0; i < images.size(); ++i) {
    std::vector<std::pair<size_t, size_t>> partners;  // count, index
    for (size_t k = 0; k < images.size(); ++k) {
      const size_t count = counts[std::min(i, k)][std::max(i, k)];
      if (k != i && count >= kMinCoarseMatches) partners.push_back({count, k});
    }
    std::sort(partners.rbegin(), partners.rend());
    partners.resize(std::min(partners.size(), kCoarsePartners));
    for (const auto& [count, k] : partners)
      pairs.insert({images[std::min(i, k)].id, images[std::max(i, k)].id});
  }
}

}  // namespace

std::vector<ImagePair> ChoosePairs(const ColmapDatabase& database,
                                   const std::vector<DatabaseImage>& images, PairChoice choice) {
  const bool all = choice == PairChoice::kExhaustive ||
                   (choice == PairChoice::kAuto && images.size() <= kExhaustivePhotos);
  if (all) return AllPairs(images);
  std::set<ImagePair> pairs;
  AddSequentialPairs(images, pairs);
  if (choice == PairChoice::kAuto) AddCoarsePairs(database, images, pairs);
  return {pairs.begin(), pairs.end()};
}

}  // namespace tetrec
