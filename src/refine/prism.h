// Triangular prisms cut into tets: the table of cuts, and the choice of the diagonals of their
// quads.
//
// If all edges at a vertex are halved, each of its tets becomes a small tet at the vertex and a
// prism: its bottom is the face opposite the vertex, its top joins the middles of the edges. Prisms
// of neighbouring tets share a quad, which both must cut by the same diagonal. Along the directed
// edge from one bottom vertex to the next, the diagonal rises (from the bottom of the first to the
// top of the second) or falls. What rises for a prism falls for its neighbour, which passes the
// edge the other way, and a prism can be cut unless all its diagonals rise or all fall (Erleben,
// Dohlmann and Sporring, "The adaptive thin shell tetrahedral mesh", 2005, section 4).
#pragma once

#include <glm/glm.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace tetrec {

// The diagonals of a prism with bottom 0, 1, 2: bit k is set if that along the edge from k to
// (k + 1) % 3 rises.
using PrismPattern = uint8_t;
constexpr bool CanBeCut(PrismPattern pattern) { return pattern != 0 && pattern != 7; }

// The three tets of a prism. They are positively oriented if a point above the top followed by the
// bottom's vertices is.
std::array<glm::uvec4, 3> CutPrism(const glm::uvec3& bottom, const glm::uvec3& top,
                                   PrismPattern pattern);

constexpr uint32_t kNoPrism = 0xFFFFFFFFu;

// Quad k of a prism, over its edge from bottom vertex k to (k + 1) % 3.
struct PrismQuad {
  uint32_t prism = kNoPrism;
  int k = 0;
};

// Each quad as the prism beyond it names it; kNoPrism: there is none. `bottoms` are consistently
// oriented: no directed edge occurs twice.
std::vector<std::array<PrismQuad, 3>> OppositeQuads(std::span<const glm::uvec3> bottoms);

// Each diagonal starts at the bottom of that vertex of its edge that has the smaller rank. A total
// order contains no cycle, so every prism can be cut.
//   rank  of each vertex that `bottoms` name, all different
std::vector<PrismPattern> DiagonalsByRank(std::span<const glm::uvec3> bottoms,
                                          std::span<const uint32_t> rank);

// As Erleben et al. solve it: passes from prism to prism and takes the first pattern that agrees
// with the prisms before. Where there is none, one diagonal is flipped, and if its other prism can
// then not be cut, one of that, until a prism can absorb the change, on a shortest such path. The
// time is linear in the prisms: nothing is returned if all these searches together take longer.
std::optional<std::vector<PrismPattern>> DiagonalsByFlips(std::span<const glm::uvec3> bottoms);

}  // namespace tetrec
