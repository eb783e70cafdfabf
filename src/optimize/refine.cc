// Coarse to fine: new vertices where the pictures are wrong, none where there is nothing.
#include "optimize/refine.h"

#include "core/error.h"
#include "mesh/delaunay.h"
#include "optimize/random.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

namespace tetrec {
namespace {

struct Edge {
  uint32_t a, b;
};

constexpr int kTetEdges[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};

std::vector<uint8_t> HullVertices(const TetMesh& mesh) {
  std::vector<uint8_t> on_hull(mesh.positions.size(), 0);
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (int face = 0; face < 4; ++face) {
      if (mesh.neighbors[t][face] != kNoTet) continue;
      for (int corner : kFaceVertices[face]) on_hull[mesh.tets[t][corner]] = 1;
    }
  }
  return on_hull;
}

double EdgeLength(const TetMesh& mesh, Edge e) {
  return glm::distance(mesh.positions[e.a], mesh.positions[e.b]);
}

Edge LongestEdge(const TetMesh& mesh, const glm::uvec4& tet) {
  Edge longest{tet[0], tet[1]};
  for (const auto& ends : kTetEdges) {
    const Edge edge{tet[ends[0]], tet[ends[1]]};
    if (EdgeLength(mesh, edge) > EdgeLength(mesh, longest)) longest = edge;
  }
  return {std::min(longest.a, longest.b), std::max(longest.a, longest.b)};
}

// The edges to split, worst tets first.
std::vector<Edge> ChooseEdges(const TetMesh& mesh, std::span<const float> error,
                              const std::vector<uint8_t>& on_hull, size_t count,
                              const RefineOptions& options) {
  std::vector<uint32_t> order(mesh.tets.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [error](uint32_t x, uint32_t y) { return error[x] > error[y]; });
  std::vector<int> splits(mesh.positions.size(), 0);
  std::set<std::pair<uint32_t, uint32_t>> taken;
  std::vector<Edge> edges;
  for (uint32_t t : order) {
    if (edges.size() >= count || error[t] <= 0.0f) break;
    const Edge edge = LongestEdge(mesh, mesh.tets[t]);
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

// A vertex is empty where no edge of its tets is opaque enough to show.
std::vector<uint8_t> EmptyVertices(const TetMesh& mesh, const VertexState& state,
                                   double empty_depth) {
  std::vector<uint8_t> empty(mesh.positions.size(), 1);
  for (const glm::uvec4& tet : mesh.tets) {
    double longest = 0.0, densest = 0.0;
    for (const auto& ends : kTetEdges) {
      longest = std::max(longest, EdgeLength(mesh, {tet[ends[0]], tet[ends[1]]}));
    }
    for (int i = 0; i < 4; ++i) {
      densest = std::max(densest, double(std::exp(state.parameters[tet[i]].a)));
    }
    if (longest * densest < empty_depth) continue;
    for (int i = 0; i < 4; ++i) empty[tet[i]] = 0;
  }
  return empty;
}

// Linear interpolation of the field at share f from a to b; density is linear, its logarithm is
// not.
glm::vec4 MixParameters(const glm::vec4& a, const glm::vec4& b, float f) {
  glm::vec4 result = glm::mix(a, b, f);
  result.a = std::log(std::max(glm::mix(std::exp(a.a), std::exp(b.a), f), 1.8e-35f));
  return result;
}

}  // namespace

RefineResult Refine(const TetMesh& mesh, const VertexState& state, std::span<const float> error,
                    const RefineOptions& options) {
  const size_t count = mesh.positions.size();
  TETREC_CHECK(error.size() == mesh.tets.size(), "one score a tet");
  const std::vector<uint8_t> on_hull = HullVertices(mesh);
  const std::vector<uint8_t> empty = EmptyVertices(mesh, state, options.empty_depth);

  RefineResult result;
  Random random(options.seed, count);
  std::vector<glm::vec3> points;
  VertexState grown;
  for (size_t v = 0; v < count; ++v) {
    if (!on_hull[v] && empty[v] && random.Uniform() < options.drop_share) {
      ++result.dropped_empty;
      continue;
    }
    points.push_back(mesh.positions[v]);
    grown.parameters.push_back(state.parameters[v]);
    grown.first_moment.push_back(state.first_moment[v]);
    grown.second_moment.push_back(state.second_moment[v]);
  }

  const double wanted = std::min(double(options.max_vertices), options.growth * double(count));
  const size_t room = wanted > double(points.size()) ? size_t(wanted) - points.size() : 0;
  for (const Edge edge : ChooseEdges(mesh, error, on_hull, room, options)) {
    // Off the exact middle, so that regular starts do not stay cospherical.
    const float f = float(0.5 + 0.1 * (random.Uniform() - 0.5));
    points.push_back(glm::mix(mesh.positions[edge.a], mesh.positions[edge.b], f));
    grown.parameters.push_back(
        MixParameters(state.parameters[edge.a], state.parameters[edge.b], f));
    grown.first_moment.push_back(
        glm::mix(state.first_moment[edge.a], state.first_moment[edge.b], f));
    grown.second_moment.push_back(
        glm::mix(state.second_moment[edge.a], state.second_moment[edge.b], f));
    ++result.split_edges;
  }

  DelaunayResult delaunay = BuildDelaunay(points);
  result.mesh = std::move(delaunay.mesh);
  for (uint32_t point : delaunay.point_of_vertex) {
    result.state.parameters.push_back(grown.parameters[point]);
    result.state.first_moment.push_back(grown.first_moment[point]);
    result.state.second_moment.push_back(grown.second_moment[point]);
  }
  return result;
}

}  // namespace tetrec
