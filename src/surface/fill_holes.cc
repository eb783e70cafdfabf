// Small holes of a surface are closed.
#include "surface/fill_holes.h"

#include "mesh/mesh_facts.h"

#include <algorithm>
#include <limits>
#include <unordered_map>
#include <unordered_set>
#include <vector>

namespace tetrec {
namespace {

constexpr size_t kMostVertices = 200;  // of a loop: the time grows with the third power
// A piece of the surface is a patch and no rim if it is smaller than this many times the hole.
constexpr double kLeastShare = 4;
constexpr double kNever = std::numeric_limits<double>::infinity();

uint64_t EdgeKey(uint32_t a, uint32_t b) { return uint64_t{std::min(a, b)} << 32 | std::max(a, b); }

double Area(const TriangleMesh& mesh, const glm::uvec3& t) {
  const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
  return 0.5 * glm::length(glm::cross(b - a, c - a));
}

// Loops of border vertices, in the direction of the triangles that would fill them.
std::vector<std::vector<uint32_t>> BorderLoops(const TriangleMesh& mesh) {
  std::unordered_set<uint64_t> directed;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) directed.insert(uint64_t{t[k]} << 32 | t[(k + 1) % 3]);
  }
  std::unordered_map<uint32_t, uint32_t> next;
  std::vector<uint32_t> starts;  // in the order of the triangles, so that results do not vary
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = t[k], to = t[(k + 1) % 3];
      if (directed.contains(uint64_t{to} << 32 | from)) continue;
      next[to] = from;
      starts.push_back(to);
    }
  }
  std::vector<std::vector<uint32_t>> loops;
  for (const uint32_t start : starts) {
    std::vector<uint32_t> loop;
    for (auto at = next.find(start); at != next.end(); at = next.find(loop.back())) {
      loop.push_back(at->second);
      next.erase(at);
    }
    if (!loop.empty()) loops.push_back(std::move(loop));
  }
  return loops;
}

double Perimeter(const TriangleMesh& mesh, const std::vector<uint32_t>& loop) {
  double length = 0;
  for (size_t i = 0; i < loop.size(); ++i) {
    length += glm::distance(glm::dvec3(mesh.positions[loop[i]]),
                            glm::dvec3(mesh.positions[loop[(i + 1) % loop.size()]]));
  }
  return length;
}

// The triangulation of least area; empty if each would double an edge.
std::vector<glm::uvec3> LeastTriangulation(const TriangleMesh& mesh,
                                           const std::vector<uint32_t>& loop,
                                           const std::unordered_set<uint64_t>& edges) {
  const size_t n = loop.size();
  std::vector<double> area(n * n, 0);  // of the part from vertex i to vertex j of the loop
  std::vector<size_t> middle(n * n, 0);
  for (size_t span = 2; span < n; ++span) {
    for (size_t i = 0; i + span < n; ++i) {
      const size_t j = i + span;
      double& least = area[i * n + j] = kNever;
      if (span + 1 < n && edges.contains(EdgeKey(loop[i], loop[j]))) continue;
      for (size_t k = i + 1; k < j; ++k) {
        const double sum =
            area[i * n + k] + area[k * n + j] + Area(mesh, {loop[i], loop[k], loop[j]});
        if (sum < least) {
          least = sum;
          middle[i * n + j] = k;
        }
      }
    }
  }
  std::vector<glm::uvec3> triangles;
  if (area[n - 1] == kNever) return triangles;
  std::vector<std::pair<size_t, size_t>> parts = {{0, n - 1}};
  while (!parts.empty()) {
    const auto [i, j] = parts.back();
    parts.pop_back();
    if (j - i < 2) continue;
    const size_t k = middle[i * n + j];
    triangles.emplace_back(loop[i], loop[k], loop[j]);
    parts.emplace_back(i, k);
    parts.emplace_back(k, j);
  }
  return triangles;
}

}  // namespace

FilledHoles FillSmallHoles(const TriangleMesh& mesh, double max_perimeter) {
  FilledHoles result{mesh, 0, 0};
  const std::vector<uint32_t> piece_of_vertex = PieceOfVertex(mesh);
  std::vector<double> area_of_piece(mesh.positions.size(), 0);
  std::unordered_set<uint64_t> edges;
  for (const glm::uvec3& t : mesh.triangles) {
    area_of_piece[piece_of_vertex[t.x]] += Area(mesh, t);
    for (int k = 0; k < 3; ++k) edges.insert(EdgeKey(t[k], t[(k + 1) % 3]));
  }
  for (const std::vector<uint32_t>& loop : BorderLoops(mesh)) {
    if (loop.size() < 3 || loop.size() > kMostVertices) continue;
    if (Perimeter(mesh, loop) > max_perimeter) continue;
    const std::vector<glm::uvec3> triangles = LeastTriangulation(mesh, loop, edges);
    double area = 0;
    for (const glm::uvec3& t : triangles) area += Area(mesh, t);
    if (area_of_piece[piece_of_vertex[loop[0]]] < kLeastShare * area) continue;
    for (const glm::uvec3& t : triangles) {
      for (int k = 0; k < 3; ++k) edges.insert(EdgeKey(t[k], t[(k + 1) % 3]));
    }
    result.mesh.triangles.insert(result.mesh.triangles.end(), triangles.begin(), triangles.end());
    result.holes += triangles.empty() ? 0 : 1;
    result.triangles += triangles.size();
  }
  return result;
}

}  // namespace tetrec
