// Refinement by the article's splits.
#include "refine/split_prisms.h"

#include "geometry/orientation.h"
#include "refine/edited_mesh.h"
#include "refine/prism.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace tetrec {
namespace {

// The tets around a vertex.
struct Star {
  uint32_t vertex = 0;
  std::vector<uint32_t> tets;
  std::vector<glm::uvec3> bottoms;  // opposite faces, as places in `link`: vertex in front, they
                                    // are positively oriented
  std::vector<uint32_t> link;       // the vertices at the other ends of its edges
};

// Evenly permuted, so that `vertex` is the first.
glm::uvec4 StartingWith(const glm::uvec4& tet, uint32_t vertex) {
  if (tet[0] == vertex) return tet;
  if (tet[1] == vertex) return {tet[1], tet[0], tet[3], tet[2]};
  if (tet[2] == vertex) return {tet[2], tet[3], tet[0], tet[1]};
  return {tet[3], tet[2], tet[1], tet[0]};
}

Star StarOf(const EditedMesh& mesh, uint32_t vertex) {
  Star star{.vertex = vertex};
  const std::span<const uint32_t> tets = mesh.TetsAt(vertex);
  star.tets.assign(tets.begin(), tets.end());
  std::unordered_map<uint32_t, uint32_t> places;
  for (const uint32_t t : star.tets) {
    const glm::uvec4 tet = StartingWith(mesh.tet(t), vertex);
    glm::uvec3 bottom;
    for (int i = 0; i < 3; ++i) {
      const auto [place, is_new] = places.emplace(tet[i + 1], uint32_t(star.link.size()));
      if (is_new) star.link.push_back(tet[i + 1]);
      bottom[i] = place->second;
    }
    star.bottoms.push_back(bottom);
  }
  return star;
}

double SquaredLength(const EditedMesh& mesh, uint32_t a, uint32_t b) {
  const glm::dvec3 edge = glm::dvec3(mesh.position(b)) - glm::dvec3(mesh.position(a));
  return glm::dot(edge, edge);
}

// The rank of each vertex of the link by its distance: the diagonal from the nearer one is the
// shorter of a quad's two.
std::vector<uint32_t> RanksByDistance(const EditedMesh& mesh, const Star& star) {
  std::vector<double> squared(star.link.size());
  for (size_t i = 0; i < squared.size(); ++i) {
    squared[i] = SquaredLength(mesh, star.vertex, star.link[i]);
  }
  std::vector<uint32_t> order(squared.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) {
    return squared[a] != squared[b] ? squared[a] < squared[b] : star.link[a] < star.link[b];
  });
  std::vector<uint32_t> ranks(order.size());
  for (uint32_t i = 0; i < order.size(); ++i) ranks[order[i]] = i;
  return ranks;
}

std::vector<PrismPattern> ChooseDiagonals(const EditedMesh& mesh, const Star& star,
                                          PrismDiagonals diagonals) {
  if (diagonals == PrismDiagonals::kFlips) {
    if (auto patterns = DiagonalsByFlips(star.bottoms)) return std::move(*patterns);
  }
  return DiagonalsByRank(star.bottoms, RanksByDistance(mesh, star));
}

bool HasShortEdge(const EditedMesh& mesh, const Star& star, double min_edge) {
  return std::ranges::any_of(star.link, [&](uint32_t other) {
    return SquaredLength(mesh, star.vertex, other) < min_edge * min_edge;
  });
}

// The middles of the edges of the boundary at the vertex are exactly in its faces.
bool KeepsBoundary(const EditedMesh& mesh, const Star& star) {
  const std::vector<std::array<PrismQuad, 3>> opposite = OppositeQuads(star.bottoms);
  for (size_t p = 0; p < star.bottoms.size(); ++p) {
    for (int k = 0; k < 3; ++k) {
      if (opposite[p][size_t(k)].prism != kNoPrism) continue;
      const uint32_t a = star.vertex, b = star.link[star.bottoms[p][k]],
                     c = star.link[star.bottoms[p][(k + 1) % 3]];
      for (const uint32_t other : {b, c}) {
        if (Orientation(mesh.position(a), mesh.position(b), mesh.position(c),
                        mesh.Middle(a, other)) != 0) {
          return false;
        }
      }
    }
  }
  return true;
}

using Parts = std::array<glm::uvec4, 4>;

// Returns the parts of each tet of the star: the small tet, then those of the prism. The middles
// are the vertices from `first_middle` on, in the order of the link.
std::vector<Parts> PartsOf(const Star& star, const std::vector<PrismPattern>& patterns,
                           uint32_t first_middle) {
  std::vector<Parts> parts;
  for (size_t p = 0; p < star.bottoms.size(); ++p) {
    const glm::uvec3& places = star.bottoms[p];
    const glm::uvec3 top = places + first_middle;
    const glm::uvec3 bottom(star.link[places[0]], star.link[places[1]], star.link[places[2]]);
    const std::array<glm::uvec4, 3> prism = CutPrism(bottom, top, patterns[p]);
    parts.push_back(
        {glm::uvec4(star.vertex, top[0], top[1], top[2]), prism[0], prism[1], prism[2]});
  }
  return parts;
}

bool AllPositive(const EditedMesh& mesh, const Star& star, const std::vector<Parts>& parts) {
  const auto position = [&](uint32_t v) {
    const bool is_old = v < mesh.vertices();
    return is_old ? mesh.position(v) : mesh.Middle(star.vertex, star.link[v - mesh.vertices()]);
  };
  return std::ranges::all_of(parts, [&](const Parts& of_tet) {
    return std::ranges::all_of(of_tet, [&](const glm::uvec4& tet) {
      return IsPositive(position(tet[0]), position(tet[1]), position(tet[2]), position(tet[3]));
    });
  });
}

bool Split(EditedMesh& mesh, const Star& star, const RefineOptions& options) {
  if (HasShortEdge(mesh, star, options.min_edge) || !KeepsBoundary(mesh, star)) return false;
  const std::vector<Parts> parts =
      PartsOf(star, ChooseDiagonals(mesh, star, options.diagonals), uint32_t(mesh.vertices()));
  if (!AllPositive(mesh, star, parts)) return false;
  for (const uint32_t other : star.link) mesh.AddMiddle(star.vertex, other);
  for (size_t p = 0; p < parts.size(); ++p) mesh.Cut(star.tets[p], parts[p]);
  return true;
}

}  // namespace

Refinement SplitPrisms(TetMesh mesh, const RefineScores& scores, const RefineOptions& options) {
  const uint64_t budget = VertexBudget(mesh.positions.size(), options);
  const uint64_t most_split =
      uint64_t(std::ceil(options.split_share * double(mesh.positions.size())));
  uint64_t split = 0, refused = 0;
  EditedMesh growing(std::move(mesh));
  for (const uint32_t vertex : WorstFirst(scores.of_vertices)) {
    if (split == most_split || !(scores.of_vertices[vertex] > 0.0f)) break;
    const Star star = StarOf(growing, vertex);
    if (growing.vertices() + star.link.size() > budget) break;
    ++(Split(growing, star, options) ? split : refused);
  }
  Refinement result = growing.Take();
  result.refused = refused;
  return result;
}

}  // namespace tetrec
