// The vertices that a mesh can do without.
#include "refine/spare_vertices.h"

#include "core/random.h"
#include "mesh/mesh_edges.h"
#include "refine/vertex_values.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <queue>
#include <utility>

namespace tetrec {
namespace {

double EdgeLength(const TetMesh& mesh, uint32_t a, uint32_t b) {
  return glm::distance(mesh.positions[a], mesh.positions[b]);
}

// A vertex is empty if no edge of its tets is opaque enough to be visible.
std::vector<uint8_t> WithoutDensity(const TetMesh& mesh, const FieldState& state,
                                    double empty_depth) {
  std::vector<uint8_t> empty(mesh.positions.size(), 1);
  const size_t components = size_t(state.layout.Components());
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    const glm::uvec4& tet = mesh.tets[t];
    double longest = 0.0, densest = 0.0;
    for (const auto& ends : kTetEdges) {
      longest = std::max(longest, EdgeLength(mesh, tet[ends[0]], tet[ends[1]]));
    }
    for (int i = 0; i < 4; ++i) {
      const size_t row = state.layout.storage == FieldStorage::kCell ? t : tet[i];
      const float parameter = state.parameters[row * components + kDensityOffset];
      densest = std::max(densest, double(ValueOf(state.layout.density(), parameter)));
    }
    if (longest * densest < empty_depth) continue;
    for (int i = 0; i < 4; ++i) empty[tet[i]] = 0;
  }
  return empty;
}

// The light that rays lose in the tets around each vertex.
std::vector<double> LightAround(const TetMesh& mesh, const std::vector<float>& visible_of_tets) {
  std::vector<double> light(mesh.positions.size(), 0.0);
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) light[mesh.tets[t][i]] += double(visible_of_tets[t]);
  }
  return light;
}

// Calls visit(vertex, neighbour, offset, weight) for each edge of each tet, both ways. The offset
// from the vertex is in mean edges of the vertex, so that nothing depends on the scene's scale;
// near neighbours weigh more.
template <class Visit>
void VisitNeighbors(const TetMesh& mesh, const std::vector<double>& mean_edges,
                    const Visit& visit) {
  for (const glm::uvec4& tet : mesh.tets) {
    for (int i = 0; i < 12; ++i) {
      const auto& ends = kTetEdges[i / 2];
      const uint32_t v = tet[ends[i % 2]], neighbor = tet[ends[1 - i % 2]];
      const glm::dvec3 offset =
          (glm::dvec3(mesh.positions[neighbor]) - glm::dvec3(mesh.positions[v])) / mean_edges[v];
      visit(v, neighbor, glm::dvec4(1.0, offset), 1.0 / glm::dot(offset, offset));
    }
  }
}

// What the neighbours of each vertex predict at its place: the weighted least-squares affine fit.
// With the weights w, the rows x = (1, offset) and M = sum of w x x^T, that is the sum of
// w (M^-1 x)_0 times the neighbours' values.
std::vector<glm::dvec4> PredictedValues(const TetMesh& mesh, const std::vector<glm::dvec4>& values,
                                        const std::vector<double>& mean_edges) {
  std::vector<glm::dmat4> moments(values.size(), glm::dmat4(1e-9));
  VisitNeighbors(mesh, mean_edges, [&](uint32_t v, uint32_t, const glm::dvec4& x, double weight) {
    moments[v] += weight * glm::outerProduct(x, x);
  });
  std::vector<glm::dvec4> first_row(values.size());
  for (size_t v = 0; v < values.size(); ++v) first_row[v] = glm::inverse(moments[v])[0];
  std::vector<glm::dvec4> predicted(values.size(), glm::dvec4(0.0));
  VisitNeighbors(mesh, mean_edges,
                 [&](uint32_t v, uint32_t neighbor, const glm::dvec4& x, double weight) {
                   predicted[v] += weight * glm::dot(first_row[v], x) * values[neighbor];
                 });
  return predicted;
}

// The share of a vertex's values in what is seen in a tet at it, on average.
constexpr double kShareOfVertex = 0.25;

// By how much the squared error would grow without each vertex, an upper estimate.
std::vector<double> ErrorsWithout(const TetMesh& mesh, const FieldState& state,
                                  const std::vector<double>& light) {
  const std::vector<double> mean_edges = MeanEdgesOfVertices(mesh);
  const std::vector<glm::dvec4> values = ValuesAtVertices(state);
  const std::vector<glm::dvec4> predicted = PredictedValues(mesh, values, mean_edges);
  std::vector<double> errors(values.size());
  for (size_t v = 0; v < values.size(); ++v) {
    errors[v] = kShareOfVertex * light[v] * SquaredChange(predicted[v], values[v], mean_edges[v]);
    if (!std::isfinite(errors[v])) errors[v] = std::numeric_limits<double>::infinity();
  }
  return errors;
}

// (V) 1 for neighbours of the marked vertices, and for these.
std::vector<uint8_t> AtOrNextTo(const TetMesh& mesh, const std::vector<uint8_t>& is_marked) {
  std::vector<uint8_t> result = is_marked;
  for (const glm::uvec4& tet : mesh.tets) {
    const bool any =
        is_marked[tet[0]] || is_marked[tet[1]] || is_marked[tet[2]] || is_marked[tet[3]];
    for (int i = 0; i < 4 && any; ++i) result[tet[i]] = 1;
  }
  return result;
}

// The tets around each vertex: those of vertex v are tets[first[v]] to tets[first[v + 1] - 1].
struct Stars {
  std::vector<uint32_t> first, tets;
};
Stars StarsOf(const TetMesh& mesh) {
  Stars stars{std::vector<uint32_t>(mesh.positions.size() + 1, 0), {}};
  for (const glm::uvec4& tet : mesh.tets) {
    for (int i = 0; i < 4; ++i) ++stars.first[tet[i] + 1];
  }
  std::partial_sum(stars.first.begin(), stars.first.end(), stars.first.begin());
  stars.tets.resize(4 * mesh.tets.size());
  std::vector<uint32_t> next(stars.first.begin(), stars.first.end() - 1);
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) stars.tets[next[mesh.tets[t][i]]++] = t;
  }
  return stars;
}

void TakeFlat(const TetMesh& mesh, const std::vector<double>& errors, double most_error,
              std::vector<uint8_t> is_fixed, SpareVertices& spare) {
  std::vector<uint32_t> flattest(errors.size());
  std::iota(flattest.begin(), flattest.end(), 0u);
  std::stable_sort(flattest.begin(), flattest.end(),
                   [&](uint32_t a, uint32_t b) { return errors[a] < errors[b]; });
  const Stars stars = StarsOf(mesh);
  double sum = 0.0;
  for (const uint32_t v : flattest) {
    if (sum + errors[v] > most_error) break;
    if (is_fixed[v]) continue;
    sum += errors[v];
    spare.is_spare[v] = 1;
    ++spare.flat;
    for (uint32_t at = stars.first[v]; at < stars.first[v + 1]; ++at) {
      for (int i = 0; i < 4; ++i) is_fixed[mesh.tets[stars.tets[at]][i]] = 1;
    }
  }
}

// The other vertices of the tets around a vertex.
std::vector<uint32_t> NeighborsOf(const TetMesh& mesh, const Stars& stars, uint32_t vertex) {
  std::vector<uint32_t> neighbors;
  for (uint32_t at = stars.first[vertex]; at < stars.first[vertex + 1]; ++at) {
    const glm::uvec4& tet = mesh.tets[stars.tets[at]];
    for (int i = 0; i < 4; ++i) {
      if (tet[i] != vertex) neighbors.push_back(tet[i]);
    }
  }
  std::ranges::sort(neighbors);
  neighbors.erase(std::unique(neighbors.begin(), neighbors.end()), neighbors.end());
  return neighbors;
}

// `count`: of all vertices that are spare then.
void TakeLeastNeeded(const TetMesh& mesh, std::vector<double> errors, uint64_t count,
                     const std::vector<uint8_t>& stays, SpareVertices& spare) {
  using Candidate = std::pair<double, uint32_t>;
  std::priority_queue<Candidate, std::vector<Candidate>, std::greater<>> candidates;
  for (uint32_t v = 0; v < errors.size(); ++v) {
    if (!stays[v] && !spare.is_spare[v]) candidates.emplace(errors[v], v);
  }
  const Stars stars = StarsOf(mesh);
  while (spare.empty + spare.flat < count && !candidates.empty()) {
    const auto [error, v] = candidates.top();
    candidates.pop();
    if (error < errors[v]) {
      candidates.emplace(errors[v], v);
      continue;
    }
    spare.is_spare[v] = 1;
    ++spare.flat;
    for (const uint32_t neighbor : NeighborsOf(mesh, stars, v)) errors[neighbor] += error;
  }
}

}  // namespace

SpareVertices FindSpareVertices(const TetMesh& mesh, const FieldState& state,
                                const RefineScores& scores, const RefineOptions& options) {
  const size_t count = mesh.positions.size();
  const std::vector<uint8_t> stays = FixedVertices(mesh, scores);
  const bool knows_light = !scores.visible_of_tets.empty();
  SpareVertices spare{std::vector<uint8_t>(count, 0)};
  std::vector<double> light;
  std::vector<uint8_t> is_empty;
  if (knows_light) {
    light = LightAround(mesh, scores.visible_of_tets);
    for (const double of_vertex : light) is_empty.push_back(of_vertex == 0.0);
  } else {
    is_empty = WithoutDensity(mesh, state, options.empty_depth);
  }
  Random random(options.seed, count);
  for (size_t v = 0; v < count; ++v) {
    if (stays[v] || !is_empty[v] || !(random.Uniform() < options.drop_share)) continue;
    spare.is_spare[v] = 1;
    ++spare.empty;
  }
  if (!knows_light || state.layout.storage == FieldStorage::kCell) return spare;
  std::vector<double> errors = ErrorsWithout(mesh, state, light);
  if (options.kept_share < 1) {
    TakeLeastNeeded(mesh, std::move(errors), uint64_t((1 - options.kept_share) * double(count)),
                    stays, spare);
    return spare;
  }
  std::vector<uint8_t> is_fixed = AtOrNextTo(mesh, spare.is_spare);
  for (size_t v = 0; v < count; ++v) is_fixed[v] |= stays[v];
  TakeFlat(mesh, errors, options.flat_error * scores.squared_error, std::move(is_fixed), spare);
  return spare;
}

}  // namespace tetrec
