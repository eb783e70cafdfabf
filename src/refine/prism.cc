// Triangular prisms cut into tets.
#include "refine/prism.h"

#include "core/error.h"

#include <unordered_map>

namespace tetrec {
namespace {

// The three tets of a prism with bottom 0, 1, 2 and top 3, 4, 5, by its pattern (table of the
// DiffTetVR article, with orientations). If the prism comes from halved edges, their volumes are
// 1/2, 1/8 and 1/4 of the tet's.
constexpr uint8_t kCuts[8][3][4] = {
    {},
    {{0, 1, 4, 2}, {0, 3, 5, 4}, {0, 2, 4, 5}},  // rises, falls, falls
    {{0, 1, 5, 2}, {1, 3, 5, 4}, {0, 1, 3, 5}},
    {{0, 1, 5, 2}, {0, 3, 5, 4}, {0, 1, 4, 5}},
    {{0, 1, 3, 2}, {2, 3, 5, 4}, {1, 2, 4, 3}},
    {{0, 1, 4, 2}, {2, 3, 5, 4}, {0, 2, 4, 3}},
    {{0, 1, 3, 2}, {1, 3, 5, 4}, {1, 2, 5, 3}},
    {},
};

// Limits the steps of all searches for prisms that absorb a change, per prism.
constexpr size_t kMostSearchSteps = 32;

constexpr PrismPattern Bit(int k) { return PrismPattern(1u << k); }

uint64_t EdgeKey(uint32_t from, uint32_t to) { return uint64_t(from) << 32 | to; }

class FlipSolver {
 public:
  explicit FlipSolver(std::span<const glm::uvec3> bottoms)
      : opposite_(OppositeQuads(bottoms)),
        patterns_(bottoms.size(), 0),
        is_set_(bottoms.size(), 0),
        is_queued_(bottoms.size(), 0),
        reached_over_(bottoms.size()),
        search_(bottoms.size(), 0) {}

  std::optional<std::vector<PrismPattern>> Solve() {
    for (uint32_t first = 0; first < patterns_.size(); ++first) {
      if (!is_set_[first] && !SolvePart(first)) return std::nullopt;
    }
    return std::move(patterns_);
  }

 private:
  // The prisms that are connected with one.
  bool SolvePart(uint32_t first) {
    std::vector<uint32_t> queue{first};
    is_queued_[first] = 1;
    for (size_t at = 0; at < queue.size(); ++at) {
      if (!Set(queue[at])) return false;
      for (const PrismQuad& next : opposite_[queue[at]]) {
        if (next.prism == kNoPrism || is_queued_[next.prism]) continue;
        is_queued_[next.prism] = 1;
        queue.push_back(next.prism);
      }
    }
    return true;
  }

  const PrismQuad& Opposite(const PrismQuad& quad) const {
    return opposite_[quad.prism][size_t(quad.k)];
  }

  // The quad has a diagonal from the prism beyond it.
  bool IsBound(const PrismQuad& quad) const {
    const uint32_t other = Opposite(quad).prism;
    return other != kNoPrism && is_set_[other];
  }

  // Gives a prism the first pattern that agrees with its neighbours.
  bool Set(uint32_t prism) {
    PrismPattern bound = 0, given = 0;
    for (int k = 0; k < 3; ++k) {
      if (!IsBound({prism, k})) continue;
      const PrismQuad& other = Opposite({prism, k});
      bound |= Bit(k);
      if (!(patterns_[other.prism] & Bit(other.k))) given |= Bit(k);
    }
    is_set_[prism] = 1;
    for (PrismPattern pattern = 1; pattern < 7; ++pattern) {
      if ((pattern & bound) != given) continue;
      patterns_[prism] = pattern;
      return true;
    }
    patterns_[prism] = given;
    return Absorb(prism);
  }

  // Flips diagonals on a shortest path from a prism that cannot be cut to one that can be cut in
  // both ways.
  bool Absorb(uint32_t prism) {
    ++search_count_;
    std::vector<uint32_t> queue{prism};
    search_[prism] = search_count_;
    reached_over_[prism] = {};
    for (size_t at = 0; at < queue.size(); ++at) {
      const uint32_t from = queue[at];
      if (++steps_ > kMostSearchSteps * patterns_.size()) return false;
      for (int k = 0; k < 3; ++k) {
        if (!IsBound({from, k})) {
          patterns_[from] ^= Bit(k);
          FlipPathTo(from);
          return true;
        }
        const PrismQuad& other = Opposite({from, k});
        if (search_[other.prism] == search_count_) continue;
        search_[other.prism] = search_count_;
        reached_over_[other.prism] = {from, k};
        if (CanBeCut(patterns_[other.prism] ^ Bit(other.k))) {
          FlipPathTo(other.prism);
          return true;
        }
        queue.push_back(other.prism);
      }
    }
    return false;
  }

  void FlipPathTo(uint32_t prism) {
    while (reached_over_[prism].prism != kNoPrism) {
      const PrismQuad& from = reached_over_[prism];
      patterns_[from.prism] ^= Bit(from.k);
      patterns_[prism] ^= Bit(Opposite(from).k);
      prism = from.prism;
    }
  }

  std::vector<std::array<PrismQuad, 3>> opposite_;
  std::vector<PrismPattern> patterns_;
  std::vector<uint8_t> is_set_, is_queued_;
  std::vector<PrismQuad> reached_over_;  // in the search that reached a prism
  std::vector<uint32_t> search_;         // the last one that reached it
  uint32_t search_count_ = 0;
  size_t steps_ = 0;
};

}  // namespace

std::array<glm::uvec4, 3> CutPrism(const glm::uvec3& bottom, const glm::uvec3& top,
                                   PrismPattern pattern) {
  TETREC_CHECK(CanBeCut(pattern), "diagonals that all rise or all fall cut no prism");
  std::array<glm::uvec4, 3> tets;
  for (int part = 0; part < 3; ++part) {
    for (int i = 0; i < 4; ++i) {
      const uint8_t corner = kCuts[pattern][part][i];
      tets[size_t(part)][i] = corner < 3 ? bottom[corner] : top[corner - 3];
    }
  }
  return tets;
}

std::vector<std::array<PrismQuad, 3>> OppositeQuads(std::span<const glm::uvec3> bottoms) {
  std::unordered_map<uint64_t, PrismQuad> quads;
  quads.reserve(3 * bottoms.size());
  for (uint32_t p = 0; p < bottoms.size(); ++p) {
    for (int k = 0; k < 3; ++k) {
      const uint64_t edge = EdgeKey(bottoms[p][k], bottoms[p][(k + 1) % 3]);
      TETREC_CHECK(quads.emplace(edge, PrismQuad{p, k}).second, "bottoms agree in orientation");
    }
  }
  std::vector<std::array<PrismQuad, 3>> opposite(bottoms.size());
  for (uint32_t p = 0; p < bottoms.size(); ++p) {
    for (int k = 0; k < 3; ++k) {
      const auto found = quads.find(EdgeKey(bottoms[p][(k + 1) % 3], bottoms[p][k]));
      if (found != quads.end()) opposite[p][size_t(k)] = found->second;
    }
  }
  return opposite;
}

std::vector<PrismPattern> DiagonalsByRank(std::span<const glm::uvec3> bottoms,
                                          std::span<const uint32_t> rank) {
  std::vector<PrismPattern> patterns;
  patterns.reserve(bottoms.size());
  for (const glm::uvec3& bottom : bottoms) {
    PrismPattern pattern = 0;
    for (int k = 0; k < 3; ++k) {
      if (rank[bottom[k]] < rank[bottom[(k + 1) % 3]]) pattern |= Bit(k);
    }
    patterns.push_back(pattern);
  }
  return patterns;
}

std::optional<std::vector<PrismPattern>> DiagonalsByFlips(std::span<const glm::uvec3> bottoms) {
  return FlipSolver(bottoms).Solve();
}

}  // namespace tetrec
