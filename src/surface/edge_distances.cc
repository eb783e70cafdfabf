// Distances on a surface, along the edges of its triangles.
#include "surface/edge_distances.h"

#include <functional>
#include <limits>
#include <queue>
#include <utility>

namespace tetrec {
namespace {

// The vertices that share a triangle with each vertex, one list after another; those of inner
// edges twice.
struct Neighbors {
  std::vector<uint32_t> begin, vertices;
};

Neighbors NeighborsOf(size_t vertex_count, std::span<const glm::uvec3> triangles) {
  Neighbors neighbors;
  neighbors.begin.assign(vertex_count + 1, 0);
  for (const glm::uvec3& t : triangles) {
    for (int k = 0; k < 3; ++k) neighbors.begin[t[k] + 1] += 2;
  }
  for (size_t v = 0; v < vertex_count; ++v) neighbors.begin[v + 1] += neighbors.begin[v];
  neighbors.vertices.resize(neighbors.begin.back());
  std::vector<uint32_t> next(neighbors.begin.begin(), neighbors.begin.end() - 1);
  for (const glm::uvec3& t : triangles) {
    for (int k = 0; k < 3; ++k) {
      neighbors.vertices[next[t[k]]++] = t[(k + 1) % 3];
      neighbors.vertices[next[t[k]]++] = t[(k + 2) % 3];
    }
  }
  return neighbors;
}

}  // namespace

std::vector<float> EdgeDistances(std::span<const glm::vec3> positions,
                                 std::span<const glm::uvec3> triangles,
                                 std::span<const uint8_t> is_source, float farthest) {
  const Neighbors neighbors = NeighborsOf(positions.size(), triangles);
  std::vector<float> distances(positions.size(), std::numeric_limits<float>::infinity());
  using Entry = std::pair<float, uint32_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (uint32_t v = 0; v < positions.size(); ++v) {
    if (!is_source[v]) continue;
    distances[v] = 0;
    queue.push({0.0f, v});
  }
  while (!queue.empty()) {
    const auto [distance, v] = queue.top();
    queue.pop();
    if (distance > distances[v]) continue;
    for (uint32_t i = neighbors.begin[v]; i < neighbors.begin[v + 1]; ++i) {
      const uint32_t w = neighbors.vertices[i];
      const float of_neighbor = distance + glm::length(positions[w] - positions[v]);
      if (of_neighbor > farthest || of_neighbor >= distances[w]) continue;
      distances[w] = of_neighbor;
      queue.push({of_neighbor, w});
    }
  }
  return distances;
}

}  // namespace tetrec
