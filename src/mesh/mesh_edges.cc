// The edges of a mesh, numbered.
#include "mesh/mesh_edges.h"

#include <algorithm>

namespace tetrec {
namespace {

uint64_t KeyOf(uint32_t a, uint32_t b) { return uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

}  // namespace

MeshEdges EdgesOf(const TetMesh& mesh) {
  std::vector<uint64_t> keys;
  keys.reserve(6 * mesh.tets.size());
  for (const glm::uvec4& tet : mesh.tets) {
    for (const auto& ends : kTetEdges) keys.push_back(KeyOf(tet[ends[0]], tet[ends[1]]));
  }
  std::vector<uint64_t> sorted = keys;
  std::ranges::sort(sorted);
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  MeshEdges edges;
  edges.ends.reserve(sorted.size());
  for (const uint64_t key : sorted) edges.ends.emplace_back(uint32_t(key >> 32), uint32_t(key));
  edges.of_tets.reserve(keys.size());
  for (const uint64_t key : keys) {
    const auto found = std::ranges::lower_bound(sorted, key);
    edges.of_tets.push_back(uint32_t(found - sorted.begin()));
  }
  return edges;
}

int LongestEdge(const TetMesh& mesh, const glm::uvec4& tet) {
  const auto length = [&](int edge) {
    return glm::distance(mesh.positions[tet[kTetEdges[edge][0]]],
                         mesh.positions[tet[kTetEdges[edge][1]]]);
  };
  int longest = 0;
  for (int edge = 1; edge < 6; ++edge) {
    if (length(edge) > length(longest)) longest = edge;
  }
  return longest;
}

std::vector<double> MeanEdgesOfVertices(const TetMesh& mesh) {
  std::vector<double> sums(mesh.positions.size(), 0.0);
  std::vector<uint32_t> counts(mesh.positions.size(), 0);
  for (const glm::uvec4& tet : mesh.tets) {
    for (const auto& ends : kTetEdges) {
      const double length =
          double(glm::distance(mesh.positions[tet[ends[0]]], mesh.positions[tet[ends[1]]]));
      for (const int end : ends) {
        sums[tet[end]] += length;
        ++counts[tet[end]];
      }
    }
  }
  for (size_t v = 0; v < sums.size(); ++v) sums[v] /= double(std::max(counts[v], 1u));
  return sums;
}

}  // namespace tetrec
