// Fans of triangles around vertices, and borders.
#include "surface/vertex_fans.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace tetrec {

VertexFans::VertexFans(const TriangleMesh& mesh)
    : begin_(mesh.positions.size() + 1, 0), triangles_(3 * mesh.triangles.size()) {
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++begin_[t[k] + 1];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  std::vector<uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) triangles_[next[mesh.triangles[t][k]]++] = t;
  }
}

std::vector<bool> BorderVertices(const TriangleMesh& mesh) {
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) edges.push_back(std::minmax({t[k], t[(k + 1) % 3]}));
  }
  std::sort(edges.begin(), edges.end());
  std::vector<bool> border(mesh.positions.size(), false);
  for (size_t e = 0; e < edges.size();) {
    size_t end = e + 1;
    while (end < edges.size() && edges[end] == edges[e]) ++end;
    if (end - e == 1) border[edges[e].first] = border[edges[e].second] = true;
    e = end;
  }
  return border;
}

}  // namespace tetrec
