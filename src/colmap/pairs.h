// Which pairs of images are matched.
#pragma once

#include "colmap/database.h"
#include "core/words.h"

#include <array>
#include <cstddef>
#include <vector>

namespace tetrec {

// kAuto: all pairs of a few images; of more, the pairs whose coarsest features match best (Wu,
// "Towards linear-time incremental structure from motion", 2013) and neighbours in the order of
// ids.
enum class PairChoice { kAuto, kExhaustive, kSequential };
template <>
inline constexpr auto kWords<PairChoice> =
    std::to_array<Word<PairChoice>>({{PairChoice::kAuto, "auto"},
                                     {PairChoice::kExhaustive, "exhaustive"},
                                     {PairChoice::kSequential, "sequential"}});

// kAuto matches all pairs of this many images or fewer.
inline constexpr size_t kExhaustivePhotos = 80;

// `images` in the order of their ids.
std::vector<ImagePair> ChoosePairs(const ColmapDatabase& database,
                                   const std::vector<DatabaseImage>& images, PairChoice choice);

}  // namespace tetrec
