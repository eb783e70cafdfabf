// Refinement by new vertices and a new triangulation.
#include "refine/insert_vertices.h"

#include "core/random.h"
#include "mesh/boundary.h"
#include "mesh/delaunay.h"
#include "mesh/locate.h"
#include "mesh/mesh_edges.h"
#include "refine/spare_vertices.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace tetrec {
namespace {

struct Edge {
  uint32_t a, b;
};

double EdgeLength(const TetMesh& mesh, Edge e) {
  return glm::distance(mesh.positions[e.a], mesh.positions[e.b]);
}

Edge EdgeToSplit(const TetMesh& mesh, const glm::uvec4& tet) {
  const auto& ends = kTetEdges[LongestEdge(mesh, tet)];
  return {std::min(tet[ends[0]], tet[ends[1]]), std::max(tet[ends[0]], tet[ends[1]])};
}

// The edges to split, worst tets first.
std::vector<Edge> ChooseEdges(const TetMesh& mesh, const std::vector<float>& error,
                              const std::vector<uint8_t>& on_hull, size_t count,
                              const RefineOptions& options) {
  std::vector<int> splits(mesh.positions.size(), 0);
  std::set<std::pair<uint32_t, uint32_t>> taken;
  std::vector<Edge> edges;
  for (const uint32_t t : WorstFirst(error)) {
    if (edges.size() >= count || error[t] <= 0.0f) break;
    const Edge edge = EdgeToSplit(mesh, mesh.tets[t]);
    // A point on an edge of the hull would make the hull rough; one on a chord between two of its
    // corners may lie in a face.
    if (on_hull[edge.a] && on_hull[edge.b]) continue;
    if (EdgeLength(mesh, edge) < options.min_edge) continue;
    if (splits[edge.a] >= options.max_splits_at_vertex ||
        splits[edge.b] >= options.max_splits_at_vertex) {
      continue;
    }
    if (!taken.insert({edge.a, edge.b}).second) continue;
    ++splits[edge.a];
    ++splits[edge.b];
    edges.push_back(edge);
  }
  return edges;
}

glm::dvec3 Centroid(const TetMesh& mesh, const glm::uvec4& tet) {
  glm::dvec3 sum(0.0);
  for (int i = 0; i < 4; ++i) sum += glm::dvec3(mesh.positions[tet[i]]);
  return 0.25 * sum;
}

// For a point that rounding puts outside the hull.
uint32_t NearestTet(const TetMesh& mesh, const glm::dvec3& point) {
  uint32_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    const double distance = glm::distance(point, Centroid(mesh, mesh.tets[t]));
    if (distance >= least) continue;
    least = distance;
    nearest = t;
  }
  return nearest;
}

// For each new tet the old one that contains its centroid; both meshes fill the same hull.
std::vector<uint32_t> OldTets(const TetMesh& mesh, const TetMesh& new_mesh) {
  std::vector<uint32_t> old_tets;
  uint32_t old = 0;
  for (const glm::uvec4& tet : new_mesh.tets) {
    const glm::dvec3 point = Centroid(new_mesh, tet);
    const uint32_t found = FindTet(mesh, point, old);
    old = found == kNoTet ? NearestTet(mesh, point) : found;
    old_tets.push_back(old);
  }
  return old_tets;
}

}  // namespace

Refinement InsertVertices(TetMesh mesh, const FieldState& state, const RefineScores& scores,
                          const RefineOptions& options) {
  const size_t count = mesh.positions.size();
  const std::vector<uint8_t> on_hull = BoundaryVertices(mesh);
  const SpareVertices spare = FindSpareVertices(mesh, state, scores, options);

  Refinement result;
  result.dropped_empty = spare.empty;
  result.dropped_flat = spare.flat;
  std::vector<glm::vec3> points;
  std::vector<uint32_t> rows;  // of the points, among old and inserted ones
  for (uint32_t v = 0; v < count; ++v) {
    if (spare.is_spare[v]) continue;
    points.push_back(mesh.positions[v]);
    rows.push_back(v);
  }

  const uint64_t wanted = VertexBudget(count, options);
  Random random(options.seed ^ 0x51DEull, count);
  const size_t room = wanted > points.size() ? wanted - points.size() : 0;
  for (const Edge edge : ChooseEdges(mesh, scores.of_tets, on_hull, room, options)) {
    // Off the exact middle, so that regular starts do not stay cospherical.
    const float f = float(0.5 + 0.1 * (random.Uniform() - 0.5));
    points.push_back(glm::mix(mesh.positions[edge.a], mesh.positions[edge.b], f));
    rows.push_back(uint32_t(count + result.split_edges));
    result.of_vertices.inserted.push_back({edge.a, edge.b, f});
    ++result.split_edges;
  }

  const bool has_cells = state.layout.storage == FieldStorage::kCell;
  if (!has_cells) mesh = {};
  DelaunayResult delaunay = BuildDelaunay(points);
  result.mesh = std::move(delaunay.mesh);
  for (const uint32_t point : delaunay.point_of_vertex) {
    result.of_vertices.kept.push_back(rows[point]);
  }
  if (has_cells) result.old_tets = OldTets(mesh, result.mesh);
  return result;
}

}  // namespace tetrec
