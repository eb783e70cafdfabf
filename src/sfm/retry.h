// Further tries for photos that stayed out of the model: which photos they concern, and whether
// their model is better.
#pragma once

#include "colmap/database.h"
#include "colmap/model.h"

#include <cstdint>
#include <map>
#include <set>
#include <vector>

namespace tetrec {

// The ids of the photos whose features are searched again: those of `missing` and, for each of
// them, the 10 photos with which it has the most matches and its 3 neighbours on each side in the
// order of ids. If nothing was registered, all photos. Sorted.
//   photos   the ids of all photos, ascending
//   matches  raw matches of the pairs that were matched
std::vector<uint32_t> ConcernedPhotos(const std::vector<uint32_t>& photos,
                                      const std::set<uint32_t>& missing,
                                      const std::map<ImagePair, uint64_t>& matches);

// The pairs to match again of a few photos: all pairs of concerned photos, and those of a missing
// photo with any other. Sorted.
std::vector<ImagePair> PairsOfRetry(const std::vector<uint32_t>& photos,
                                    const std::vector<uint32_t>& concerned,
                                    const std::set<uint32_t>& missing);

// The same of many photos, of whose pairs only some were matched, too: those of a missing photo
// with the photos that it concerns itself, and those of concerned photos that see the same.
//   related   pairs with verified matches
std::vector<ImagePair> LikelyPairsOfRetry(const std::vector<uint32_t>& photos,
                                          const std::vector<uint32_t>& concerned,
                                          const std::set<uint32_t>& missing,
                                          const std::map<ImagePair, uint64_t>& matches,
                                          const std::set<ImagePair>& related);

// True if the second model registered more photos, without an error that shows that they are wrong:
// above 1 px, it may be a quarter more than before. Any model is better than none.
bool IsBetterModel(const ColmapModel& before, const ColmapModel& after);

}  // namespace tetrec
