// Edge counts by sorting, components by union-find.
#include "eval/mesh_facts.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace tetrec {
namespace {

struct Edge {
  uint32_t low, high;
  bool forward;  // its face runs from low to high
  bool SameEnds(const Edge& other) const { return low == other.low && high == other.high; }
};

std::vector<Edge> SortedEdges(const TriangleMesh& mesh) {
  std::vector<Edge> edges;
  edges.reserve(mesh.triangles.size() * 3);
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      const uint32_t a = triangle[i], b = triangle[(i + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), a < b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.low != b.low ? a.low < b.low : a.high < b.high;
  });
  return edges;
}

void CountEdges(const TriangleMesh& mesh, MeshFacts& facts) {
  const std::vector<Edge> edges = SortedEdges(mesh);
  for (size_t begin = 0; begin < edges.size();) {
    size_t end = begin + 1;
    while (end < edges.size() && edges[end].SameEnds(edges[begin])) ++end;
    const bool good_pair = end - begin == 2 && edges[begin].forward != edges[begin + 1].forward;
    if (end - begin == 1) {
      ++facts.boundary_edges;
    } else if (!good_pair) {
      ++facts.non_manifold_edges;
    }
    begin = end;
  }
}

uint64_t CountComponents(const TriangleMesh& mesh) {
  std::vector<uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root_of = [&](uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  std::vector<bool> used(parent.size(), false);
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) used[triangle[i]] = true;
    parent[root_of(triangle[1])] = root_of(triangle[0]);
    parent[root_of(triangle[2])] = root_of(triangle[0]);
  }
  uint64_t components = 0;
  for (uint32_t v = 0; v < parent.size(); ++v) components += used[v] && root_of(v) == v;
  return components;
}

}  // namespace

MeshFacts MeasureMesh(const TriangleMesh& mesh) {
  MeshFacts facts;
  facts.vertices = mesh.positions.size();
  facts.faces = mesh.triangles.size();
  for (const glm::vec3& position : mesh.positions) facts.bounds.Add(glm::dvec3(position));
  CountEdges(mesh, facts);
  facts.components = CountComponents(mesh);
  facts.watertight = facts.faces > 0 && facts.boundary_edges == 0 && facts.non_manifold_edges == 0;
  const glm::dvec3 origin = facts.bounds.IsEmpty() ? glm::dvec3(0.0) : facts.bounds.Center();
  double volume = 0;
  for (const glm::uvec3& triangle : mesh.triangles) {
    const glm::dvec3 a = glm::dvec3(mesh.positions[triangle[0]]) - origin;
    const glm::dvec3 b = glm::dvec3(mesh.positions[triangle[1]]) - origin;
    const glm::dvec3 c = glm::dvec3(mesh.positions[triangle[2]]) - origin;
    facts.area += 0.5 * glm::length(glm::cross(b - a, c - a));
    volume += glm::dot(a, glm::cross(b, c)) / 6;
  }
  if (facts.watertight) facts.volume = volume;
  return facts;
}

}  // namespace tetrec
