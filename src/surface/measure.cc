// Facts about a triangle surface.
#include "surface/measure.h"

#include <algorithm>
#include <map>
#include <vector>

namespace tetrec {
namespace {

struct HalfEdge {
  uint32_t from, to;
  uint64_t Key() const { return uint64_t{std::min(from, to)} << 32 | std::max(from, to); }
};

// Vertices whose triangles' opposite edges do not form one chain or ring.
uint64_t CountNonManifoldVertices(const TriangleMesh& mesh) {
  std::vector<std::vector<HalfEdge>> links(mesh.positions.size());
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) links[t[k]].push_back({t[(k + 1) % 3], t[(k + 2) % 3]});
  }
  uint64_t count = 0;
  for (const std::vector<HalfEdge>& link : links) {
    std::map<uint32_t, uint32_t> parent;
    const auto root = [&](uint32_t v) {
      while (parent.at(v) != v) v = parent.at(v);
      return v;
    };
    for (const HalfEdge& e : link) {
      parent.try_emplace(e.from, e.from);
      parent.try_emplace(e.to, e.to);
    }
    size_t chains = parent.size();
    for (const HalfEdge& e : link) {
      const uint32_t a = root(e.from), b = root(e.to);
      if (a == b) continue;
      parent[a] = b;
      --chains;
    }
    count += chains > 1;
  }
  return count;
}

}  // namespace

SurfaceFacts MeasureSurface(const TriangleMesh& mesh) {
  SurfaceFacts facts;
  if (mesh.triangles.empty()) return facts;
  const glm::dvec3 origin(mesh.positions[0]);
  std::vector<HalfEdge> edges;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a = glm::dvec3(mesh.positions[t.x]) - origin,
                     b = glm::dvec3(mesh.positions[t.y]) - origin,
                     c = glm::dvec3(mesh.positions[t.z]) - origin;
    facts.area += 0.5 * glm::length(glm::cross(b - a, c - a));
    facts.volume += glm::dot(a, glm::cross(b, c)) / 6;
    for (int k = 0; k < 3; ++k) edges.push_back({t[k], t[(k + 1) % 3]});
  }
  std::sort(edges.begin(), edges.end(),
            [](const HalfEdge& a, const HalfEdge& b) { return a.Key() < b.Key(); });
  uint64_t edge_count = 0;
  for (size_t begin = 0, end; begin < edges.size(); begin = end, ++edge_count) {
    for (end = begin; end < edges.size() && edges[end].Key() == edges[begin].Key();) ++end;
    if (end - begin == 1) {
      ++facts.border_edges;
    } else if (end - begin > 2 || edges[begin].from == edges[begin + 1].from) {
      ++facts.non_manifold_edges;
    }
  }
  facts.non_manifold_vertices = CountNonManifoldVertices(mesh);
  facts.euler_characteristic =
      int64_t(mesh.positions.size()) - int64_t(edge_count) + int64_t(mesh.triangles.size());
  return facts;
}

}  // namespace tetrec
