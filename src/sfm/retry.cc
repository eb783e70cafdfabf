// Further tries for photos that stayed out of the model.
#include "sfm/retry.h"

#include <algorithm>
#include <utility>

namespace tetrec {
namespace {

constexpr size_t kPartners = 10, kNeighbors = 3;
// A finer feature is located less exactly relative to its size, more photos fit a little worse.
constexpr double kErrorGrowth = 1.25, kSmallError_px = 1;

ImagePair PairOf(uint32_t a, uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

// The photos with which the i-th one has the most matches, and its neighbours.
std::set<uint32_t> PartnersOf(const std::vector<uint32_t>& photos, size_t i,
                              const std::map<ImagePair, uint64_t>& matches) {
  const uint32_t photo = photos[i];
  std::vector<std::pair<uint64_t, uint32_t>> partners;  // matches, id
  for (const auto& [pair, count] : matches) {
    if (pair.first == photo) partners.push_back({count, pair.second});
    if (pair.second == photo) partners.push_back({count, pair.first});
  }
  std::sort(partners.rbegin(), partners.rend());
  partners.resize(std::min(partners.size(), kPartners));
  std::set<uint32_t> ids;
  for (const auto& [count, partner] : partners) {
    if (count > 0) ids.insert(partner);
  }
  const size_t first = i < kNeighbors ? 0 : i - kNeighbors,
               last = std::min(i + kNeighbors, photos.size() - 1);
  for (size_t k = first; k <= last; ++k) {
    if (k != i) ids.insert(photos[k]);
  }
  return ids;
}

}  // namespace

std::vector<uint32_t> ConcernedPhotos(const std::vector<uint32_t>& photos,
                                      const std::set<uint32_t>& missing,
                                      const std::map<ImagePair, uint64_t>& matches) {
  if (missing.size() >= photos.size()) return photos;
  std::set<uint32_t> concerned = missing;
  for (size_t i = 0; i < photos.size(); ++i) {
    if (!missing.contains(photos[i])) continue;
    concerned.merge(PartnersOf(photos, i, matches));
  }
  return {concerned.begin(), concerned.end()};
}

std::vector<ImagePair> PairsOfRetry(const std::vector<uint32_t>& photos,
                                    const std::vector<uint32_t>& concerned,
                                    const std::set<uint32_t>& missing) {
  std::set<ImagePair> pairs;
  for (size_t i = 0; i < concerned.size(); ++i) {
    for (size_t k = i + 1; k < concerned.size(); ++k) {
      pairs.insert(PairOf(concerned[i], concerned[k]));
    }
  }
  for (const uint32_t photo : missing) {
    for (const uint32_t other : photos) {
      if (other != photo) pairs.insert(PairOf(photo, other));
    }
  }
  return {pairs.begin(), pairs.end()};
}

std::vector<ImagePair> LikelyPairsOfRetry(const std::vector<uint32_t>& photos,
                                          const std::vector<uint32_t>& concerned,
                                          const std::set<uint32_t>& missing,
                                          const std::map<ImagePair, uint64_t>& matches,
                                          const std::set<ImagePair>& related) {
  std::set<ImagePair> pairs;
  for (size_t i = 0; i < photos.size(); ++i) {
    if (!missing.contains(photos[i])) continue;
    for (const uint32_t partner : PartnersOf(photos, i, matches)) {
      pairs.insert(PairOf(photos[i], partner));
    }
  }
  const auto is_concerned = [&](uint32_t photo) {
    return std::binary_search(concerned.begin(), concerned.end(), photo);
  };
  for (const ImagePair& pair : related) {
    if (is_concerned(pair.first) && is_concerned(pair.second)) pairs.insert(pair);
  }
  return {pairs.begin(), pairs.end()};
}

bool IsBetterModel(const ColmapModel& before, const ColmapModel& after) {
  if (after.images.size() <= before.images.size()) return false;
  if (before.images.empty()) return true;
  const double error_px = MeanReprojectionError_px(after);
  return error_px <= std::max(kSmallError_px, kErrorGrowth * MeanReprojectionError_px(before));
}

}  // namespace tetrec
