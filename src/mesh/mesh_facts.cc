// Edge counts by sorting, pieces and fans by union-find.
#include "mesh/mesh_facts.h"

#include "core/disjoint_sets.h"

#include <algorithm>
#include <span>

namespace tetrec {
namespace {

struct Edge {
  uint32_t low, high;
  bool forward;  // its triangle runs from low to high
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

// Returns the number of edges.
uint64_t CountEdges(const TriangleMesh& mesh, MeshFacts& facts) {
  const std::vector<Edge> edges = SortedEdges(mesh);
  uint64_t count = 0;
  for (size_t begin = 0; begin < edges.size(); ++count) {
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
  return count;
}

// The edge of a triangle that lies opposite to one of its vertices.
struct OppositeEdge {
  uint32_t from, to;
};

bool IsOneFan(std::span<const OppositeEdge> opposite) {
  std::vector<uint32_t> ring;
  for (const OppositeEdge& edge : opposite) {
    ring.push_back(edge.from);
    ring.push_back(edge.to);
  }
  std::sort(ring.begin(), ring.end());
  ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  const auto place = [&](uint32_t vertex) {
    return uint32_t(std::lower_bound(ring.begin(), ring.end(), vertex) - ring.begin());
  };
  DisjointSets chains(ring.size());
  for (const OppositeEdge& edge : opposite) chains.Join(place(edge.from), place(edge.to));
  for (uint32_t i = 0; i < ring.size(); ++i) {
    if (chains.Root(i) != 0) return false;
  }
  return true;
}

// Vertices whose opposite edges do not form one chain or ring, and those that have any.
void CountVertices(const TriangleMesh& mesh, MeshFacts& facts, uint64_t& used) {
  std::vector<size_t> begin(mesh.positions.size() + 1, 0);
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) ++begin[triangle[i] + 1];
  }
  for (size_t v = 0; v < mesh.positions.size(); ++v) begin[v + 1] += begin[v];
  std::vector<OppositeEdge> opposite(3 * mesh.triangles.size());
  std::vector<size_t> next(begin.begin(), begin.end() - 1);
  for (const glm::uvec3& triangle : mesh.triangles) {
    for (int i = 0; i < 3; ++i) {
      opposite[next[triangle[i]]++] = {triangle[(i + 1) % 3], triangle[(i + 2) % 3]};
    }
  }
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const std::span own(opposite.data() + begin[v], begin[v + 1] - begin[v]);
    if (own.empty()) continue;
    ++used;
    facts.non_manifold_vertices += !IsOneFan(own);
  }
}

uint64_t CountComponents(const TriangleMesh& mesh) {
  const std::vector<uint32_t> piece = PieceOfVertex(mesh);
  std::vector<bool> counted(mesh.positions.size(), false);
  uint64_t components = 0;
  for (const glm::uvec3& triangle : mesh.triangles) {
    components += !counted[piece[triangle[0]]];
    counted[piece[triangle[0]]] = true;
  }
  return components;
}

void MeasureAreaAndVolume(const TriangleMesh& mesh, MeshFacts& facts) {
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
}

}  // namespace

MeshFacts MeasureMesh(const TriangleMesh& mesh) {
  MeshFacts facts;
  facts.vertices = mesh.positions.size();
  facts.faces = mesh.triangles.size();
  for (const glm::vec3& position : mesh.positions) facts.bounds.Add(glm::dvec3(position));
  uint64_t used_vertices = 0;
  const uint64_t edges = CountEdges(mesh, facts);
  CountVertices(mesh, facts, used_vertices);
  facts.euler_characteristic = int64_t(used_vertices) - int64_t(edges) + int64_t(facts.faces);
  facts.components = CountComponents(mesh);
  facts.watertight = facts.faces > 0 && facts.boundary_edges == 0 && facts.non_manifold_edges == 0;
  MeasureAreaAndVolume(mesh, facts);
  return facts;
}

std::vector<uint32_t> PieceOfVertex(const TriangleMesh& mesh) {
  DisjointSets sets(mesh.positions.size());
  for (const glm::uvec3& triangle : mesh.triangles) {
    sets.Join(triangle.x, triangle.y);
    sets.Join(triangle.x, triangle.z);
  }
  std::vector<uint32_t> piece(mesh.positions.size());
  for (uint32_t v = 0; v < piece.size(); ++v) piece[v] = sets.Root(v);
  return piece;
}

}  // namespace tetrec
