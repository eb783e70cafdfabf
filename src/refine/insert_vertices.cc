// Refinement by new vertices and a new triangulation.
#include "refine/insert_vertices.h"

#include "core/random.h"
#include "mesh/boundary.h"
#include "mesh/delaunay.h"
#include "mesh/locate.h"
#include "mesh/mesh_edges.h"
#include "refine/darkened.h"
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

// What the vertices of a new mesh are made of.
struct Plan {
  std::vector<uint8_t> is_spare;    // (V) old vertices that go
  std::vector<Edge> edges;          // that may be split, the most urgent first
  std::vector<PlaceInTet> patches;  // new vertices with the values of the old field
};

// A row between the rows of a tet, in three steps between two rows each.
uint32_t AppendPatch(const PlaceInTet& place, uint32_t next_row, std::vector<RowSource>& inserted) {
  const glm::uvec4& v = place.vertices;
  const glm::dvec4& w = place.weights;
  const auto share = [](double a, double b) { return a + b > 0 ? float(b / (a + b)) : 0.0f; };
  inserted.push_back({v[0], v[1], share(w[0], w[1])});
  inserted.push_back({v[2], v[3], share(w[2], w[3])});
  inserted.push_back({next_row, next_row + 1, share(w[0] + w[1], w[2] + w[3])});
  return next_row + 2;
}

struct NewVertices {
  std::vector<glm::vec3> points;
  std::vector<uint32_t> rows;  // of the points, among old and inserted ones
  std::vector<RowSource> inserted;
  uint64_t split_edges = 0;
};

// As many edges are split as the budget leaves room for.
NewVertices VerticesOf(const TetMesh& mesh, const Plan& plan, const RefineOptions& options) {
  const size_t count = mesh.positions.size();
  NewVertices vertices;
  auto& [points, rows, inserted, split_edges] = vertices;
  for (uint32_t v = 0; v < count; ++v) {
    if (plan.is_spare[v]) continue;
    points.push_back(mesh.positions[v]);
    rows.push_back(v);
  }
  const auto next_row = [&] { return uint32_t(count + vertices.inserted.size()); };
  for (const PlaceInTet& patch : plan.patches) {
    points.push_back(patch.position);
    rows.push_back(AppendPatch(patch, next_row(), inserted));
  }
  const uint64_t wanted = VertexBudget(count, options);
  Random random(options.seed ^ 0x51DEull, count);
  for (const Edge edge : plan.edges) {
    if (points.size() >= wanted) break;
    // Off the exact middle, so that regular starts do not stay cospherical.
    const float f = float(0.5 + 0.1 * (random.Uniform() - 0.5));
    points.push_back(glm::mix(mesh.positions[edge.a], mesh.positions[edge.b], f));
    rows.push_back(next_row());
    inserted.push_back({edge.a, edge.b, f});
    ++split_edges;
  }
  return vertices;
}

Refinement Triangulate(NewVertices vertices) {
  DelaunayResult delaunay = BuildDelaunay(vertices.points);
  Refinement result;
  result.mesh = std::move(delaunay.mesh);
  result.of_vertices.inserted = std::move(vertices.inserted);
  for (const uint32_t point : delaunay.point_of_vertex) {
    result.of_vertices.kept.push_back(vertices.rows[point]);
  }
  result.split_edges = vertices.split_edges;
  return result;
}

std::vector<float> DensitiesAtVertices(const FieldState& state) {
  const size_t components = size_t(state.layout.Components());
  std::vector<float> values(state.rows());
  for (size_t v = 0; v < values.size(); ++v) {
    values[v] = ValueOf(state.layout.density(), state.parameters[v * components + kDensityOffset]);
  }
  return values;
}

struct Mending {
  uint64_t put_back = 0, patches = 0;
};

// Puts vertices where the new mesh would be opaque and the old one is not: spare ones return, and
// patches are added, a share of the vertices at most.
Mending Mend(const TetMesh& mesh, const FieldState& state, const Refinement& refined,
             uint64_t most_vertices, Plan& plan) {
  constexpr double kMostPatches = 0.01;
  std::vector<uint32_t> gone;
  for (uint32_t v = 0; v < plan.is_spare.size(); ++v) {
    if (plan.is_spare[v]) gone.push_back(v);
  }
  Mending mending;
  const DarkenedPlaces darkened =
      FindDarkened(mesh, DensitiesAtVertices(state), gone, refined.mesh, refined.of_vertices);
  const size_t stay = mesh.positions.size() - gone.size();
  uint64_t room = most_vertices > stay ? most_vertices - stay : 0;
  for (const uint32_t v : darkened.vertices) {
    if (room == 0) break;
    plan.is_spare[v] = 0;
    ++mending.put_back;
    --room;
  }
  mending.patches = std::min({room, uint64_t(darkened.places.size()),
                              uint64_t(kMostPatches * double(refined.mesh.positions.size()))});
  plan.patches.assign(darkened.places.begin(),
                      darkened.places.begin() + ptrdiff_t(mending.patches));
  return mending;
}

// A triangulation takes more memory than all else here, so what it can do without is freed before.
Refinement TriangulateAndMend(TetMesh mesh, const FieldState& state, NewVertices vertices,
                              const RefineOptions& options, Plan& plan) {
  mesh.neighbors = std::vector<glm::uvec4>();
  Refinement first = Triangulate(std::move(vertices));
  mesh.neighbors = ComputeNeighbors(mesh.tets, mesh.positions.size());
  const Mending mending = Mend(mesh, state, first, options.max_vertices, plan);
  if (mending.put_back + mending.patches == 0) return first;
  first = {};
  NewVertices mended = VerticesOf(mesh, plan, options);
  mesh = {};
  Refinement result = Triangulate(std::move(mended));
  result.put_back = mending.put_back;
  result.patches = mending.patches;
  return result;
}

}  // namespace

Refinement InsertVertices(TetMesh mesh, const FieldState& state, const RefineScores& scores,
                          const RefineOptions& options) {
  const SpareVertices spare = FindSpareVertices(mesh, state, scores, options);
  const uint64_t kept = mesh.positions.size() - spare.empty - spare.flat;
  const uint64_t wanted = VertexBudget(mesh.positions.size(), options);
  Plan plan{spare.is_spare,
            ChooseEdges(mesh, scores.of_tets, BoundaryVertices(mesh),
                        wanted > kept ? wanted - kept : 0, options),
            {}};
  NewVertices vertices = VerticesOf(mesh, plan, options);
  Refinement result;
  if (state.layout.storage == FieldStorage::kCell) {
    result = Triangulate(std::move(vertices));
    result.old_tets = OldTets(mesh, result.mesh);
  } else {
    result = TriangulateAndMend(std::move(mesh), state, std::move(vertices), options, plan);
  }
  result.dropped_empty = spare.empty;
  result.dropped_flat = spare.flat;
  return result;
}

}  // namespace tetrec
