#include "core/random.h"
#include "field/extra_attribute.h"
#include "mesh/delaunay.h"
#include "refine/refine.h"
#include "refine/refined_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <vector>

namespace tetrec {
namespace {

// Bounds the sum of the rounding errors of exp and log of a density (log below 3: 2e-7 relative),
// of the point itself and of the blend, each in float on values below 8.
constexpr float kRounding = 8e-6f;

// Colour, density (not its logarithm) and the moments are all linear in space.
glm::vec4 LinearRow(const glm::vec3& p, float scale) {
  return scale * glm::vec4(0.5f + 0.2f * p.x, 0.4f - 0.3f * p.y, 0.3f + 0.1f * (p.x + p.z),
                           4.0f + 1.5f * p.x - p.y + 0.5f * p.z);
}

void Append(FieldState& state, const glm::vec4& parameters, const glm::vec4& first,
            const glm::vec4& second) {
  for (int c = 0; c < 4; ++c) {
    state.parameters.push_back(parameters[c]);
    state.first_moment.push_back(first[c]);
    state.second_moment.push_back(second[c]);
  }
}

// A row of the standard layout.
glm::vec4 RowOf(const std::vector<float>& values, size_t row) {
  return {values[4 * row], values[4 * row + 1], values[4 * row + 2], values[4 * row + 3]};
}

FieldState LinearState(const TetMesh& mesh) {
  FieldState state;
  for (const glm::vec3& p : mesh.positions) {
    glm::vec4 row = LinearRow(p, 1.0f);
    row.a = std::log(row.a);
    Append(state, row, LinearRow(p, 0.1f), LinearRow(p, 0.01f));
  }
  return state;
}

// Grey, with the given density and zero moments.
FieldState StateOfLogDensity(const TetMesh& mesh,
                             const std::function<float(const glm::vec3&)>& log_density) {
  FieldState state;
  for (const glm::vec3& p : mesh.positions) {
    Append(state, {0.5f, 0.5f, 0.5f, log_density(p)}, glm::vec4(0.0f), glm::vec4(0.0f));
  }
  return state;
}

std::array<float, 3> Key(const glm::vec3& p) { return {p.x, p.y, p.z}; }

std::map<std::array<float, 3>, uint32_t> VertexAt(const TetMesh& mesh) {
  std::map<std::array<float, 3>, uint32_t> result;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) result[Key(mesh.positions[v])] = v;
  return result;
}

// Vertices of `after` at places where `before` has none.
std::vector<uint32_t> NewVertices(const TetMesh& before, const TetMesh& after) {
  const auto old = VertexAt(before);
  std::vector<uint32_t> result;
  for (uint32_t v = 0; v < after.positions.size(); ++v) {
    if (!old.contains(Key(after.positions[v]))) result.push_back(v);
  }
  return result;
}

struct Edge {
  uint32_t a, b;
  bool operator==(const Edge&) const = default;
};

std::vector<Edge> EdgesOf(const glm::uvec4& tet) {
  std::vector<Edge> edges;
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j) {
      edges.push_back({std::min(tet[i], tet[j]), std::max(tet[i], tet[j])});
    }
  }
  return edges;
}

double Length(const TetMesh& mesh, Edge e) {
  return glm::distance(glm::dvec3(mesh.positions[e.a]), glm::dvec3(mesh.positions[e.b]));
}

Edge LongestEdge(const TetMesh& mesh, const glm::uvec4& tet) {
  const std::vector<Edge> edges = EdgesOf(tet);
  return *std::max_element(edges.begin(), edges.end(),
                           [&mesh](Edge x, Edge y) { return Length(mesh, x) < Length(mesh, y); });
}

// The edge of the mesh that contains a point: the one for which the detour over the point vanishes.
Edge EdgeThrough(const TetMesh& mesh, const glm::vec3& point) {
  Edge best{0, 0};
  double least = 1e30;
  for (const glm::uvec4& tet : mesh.tets) {
    for (const Edge e : EdgesOf(tet)) {
      const double detour = glm::distance(glm::dvec3(mesh.positions[e.a]), glm::dvec3(point)) +
                            glm::distance(glm::dvec3(mesh.positions[e.b]), glm::dvec3(point)) -
                            Length(mesh, e);
      if (detour < least) {
        least = detour;
        best = e;
      }
    }
  }
  EXPECT_LT(least, 1e-6) << "the point lies on no edge";
  return best;
}

// Vertices without a visible density in any of their tets, except for corners of the box.
std::vector<uint8_t> EmptyInside(const TetMesh& mesh, const FieldState& state, float visible_log) {
  std::vector<uint8_t> empty(mesh.positions.size(), 1);
  for (const glm::uvec4& tet : mesh.tets) {
    bool seen = false;
    for (int i = 0; i < 4; ++i) seen |= state.parameters[4 * tet[i] + 3] > visible_log;
    for (int i = 0; i < 4 && seen; ++i) empty[tet[i]] = 0;
  }
  for (size_t v = 0; v < empty.size(); ++v) empty[v] &= !IsCorner(mesh.positions[v]);
  return empty;
}

RefineResult Refine(const TetMesh& mesh, const FieldState& state, const std::vector<float>& error,
                    const RefineOptions& options) {
  return Refine(mesh, state, RefineScores{.of_tets = error, .of_vertices = {}}, options);
}

RefineOptions KeepAll() {
  RefineOptions options;
  options.drop_share = 0.0;
  return options;
}

TEST(InsertVertices, PutsNewVerticesOnlyWhereTheErrorIs) {
  const TetMesh mesh = JitteredBox();
  std::vector<float> error(mesh.tets.size(), 0.0f);
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    float least_x = 1.0f;
    for (int i = 0; i < 4; ++i) least_x = std::min(least_x, mesh.positions[mesh.tets[t][i]].x);
    if (least_x > 0.0f) error[t] = 1.0f;
  }
  const RefineResult result = Refine(mesh, LinearState(mesh), error, KeepAll());
  const std::vector<uint32_t> added = NewVertices(mesh, result.mesh);
  EXPECT_EQ(added.size(), result.split_edges);
  EXPECT_GT(added.size(), 20u);
  for (const uint32_t v : added) EXPECT_GT(result.mesh.positions[v].x, 0.0f);
}

TEST(InsertVertices, SplitsTheLongestEdgeOfTheWorstTetFirst) {
  const TetMesh mesh = JitteredBox();
  RefineOptions options = KeepAll();
  options.max_vertices = mesh.positions.size() + 1;
  int tried = 0;
  for (size_t worst = 0; worst < mesh.tets.size() && tried < 10; worst += 97) {
    const Edge longest = LongestEdge(mesh, mesh.tets[worst]);
    if (IsCorner(mesh.positions[longest.a]) && IsCorner(mesh.positions[longest.b])) continue;
    ++tried;
    std::vector<float> error(mesh.tets.size(), 1.0f);
    error[worst] = 1.5f;
    const RefineResult result = Refine(mesh, LinearState(mesh), error, options);
    const std::vector<uint32_t> added = NewVertices(mesh, result.mesh);
    ASSERT_EQ(added.size(), 1u);
    EXPECT_EQ(EdgeThrough(mesh, result.mesh.positions[added[0]]), longest) << "tet " << worst;
  }
  EXPECT_EQ(tried, 10);
}

TEST(InsertVertices, KeepsToTheVertexBudgetAndToTheGrowth) {
  const TetMesh mesh = JitteredBox();
  const size_t count = mesh.positions.size();
  const std::vector<float> error(mesh.tets.size(), 1.0f);
  RefineOptions options = KeepAll();
  options.max_vertices = count + 7;
  EXPECT_EQ(Refine(mesh, LinearState(mesh), error, options).mesh.positions.size(), count + 7);
  options.max_vertices = count / 2;
  EXPECT_EQ(Refine(mesh, LinearState(mesh), error, options).split_edges, 0u);
  options.max_vertices = 1000000;
  for (const double growth : {1.0, 1.25, 1.5}) {
    options.growth = growth;
    options.max_splits_at_vertex = 100;  // so that only growth limits
    EXPECT_EQ(Refine(mesh, LinearState(mesh), error, options).mesh.positions.size(),
              size_t(growth * double(count)));
  }
}

TEST(InsertVertices, KeepsTheBoxWholeRoundAfterRound) {
  TetMesh mesh = JitteredBox(4);
  FieldState state = LinearState(mesh);
  for (uint64_t round = 0; round < 4; ++round) {
    const size_t before = mesh.positions.size();
    RefineOptions options;
    options.seed = round;
    RefineResult result = Refine(mesh, state, std::vector<float>(mesh.tets.size(), 1.0f), options);
    mesh = std::move(result.mesh);
    state = std::move(result.state);
    EXPECT_GT(mesh.positions.size(), before);
    EXPECT_NO_THROW(CheckTetMesh(mesh));
    const TetMeshQuality quality = MeasureQuality(mesh);
    EXPECT_EQ(quality.boundary_faces, 12u);
    EXPECT_NEAR(quality.total_volume, 8.0, 8e-11);  // a sum of some thousand doubles
    EXPECT_EQ(std::count_if(mesh.positions.begin(), mesh.positions.end(), IsCorner), 8);
    EXPECT_EQ(state.parameters.size(), 4 * mesh.positions.size());
    EXPECT_EQ(state.first_moment.size(), 4 * mesh.positions.size());
    EXPECT_EQ(state.second_moment.size(), 4 * mesh.positions.size());
  }
}

TEST(InsertVertices, ReproducesALinearFieldAtEveryNewVertex) {
  const TetMesh mesh = JitteredBox();
  const std::vector<float> error(mesh.tets.size(), 1.0f);
  const RefineResult result = Refine(mesh, LinearState(mesh), error, KeepAll());
  const std::vector<uint32_t> added = NewVertices(mesh, result.mesh);
  EXPECT_GT(added.size(), 100u);
  for (const uint32_t v : added) {
    const glm::vec3& p = result.mesh.positions[v];
    glm::vec4 row = RowOf(result.state.parameters, v);
    row.a = std::exp(row.a);
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(row[i], LinearRow(p, 1.0f)[i], kRounding);
      EXPECT_NEAR(result.state.first_moment[4 * v + i], LinearRow(p, 0.1f)[i], 0.1f * kRounding);
      EXPECT_NEAR(result.state.second_moment[4 * v + i], LinearRow(p, 0.01f)[i], 0.01f * kRounding);
    }
  }
}

TEST(InsertVertices, LeavesTheOldVerticesAsTheyWere) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = LinearState(mesh);
  const RefineResult result =
      Refine(mesh, state, std::vector<float>(mesh.tets.size(), 1.0f), KeepAll());
  const auto now = VertexAt(result.mesh);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const auto found = now.find(Key(mesh.positions[v]));
    ASSERT_NE(found, now.end()) << "vertex " << v;
    EXPECT_EQ(RowOf(result.state.parameters, found->second), RowOf(state.parameters, v));
    EXPECT_EQ(RowOf(result.state.first_moment, found->second), RowOf(state.first_moment, v));
    EXPECT_EQ(RowOf(result.state.second_moment, found->second), RowOf(state.second_moment, v));
  }
}

TEST(InsertVertices, DropsTheGivenShareOfTheEmptyVerticesAndNoOther) {
  const TetMesh mesh = JitteredBox(12);
  const FieldState state =
      StateOfLogDensity(mesh, [](const glm::vec3& p) { return p.x < 0 ? -20.0f : 6.0f; });
  const std::vector<uint8_t> empty = EmptyInside(mesh, state, 0.0f);
  const double empty_count = double(std::count(empty.begin(), empty.end(), 1));
  ASSERT_GT(empty_count, 400);
  for (const double share : {0.0, 0.3, 0.5, 1.0}) {
    RefineOptions options;
    options.drop_share = share;
    const RefineResult result =
        Refine(mesh, state, std::vector<float>(mesh.tets.size(), 0.0f), options);
    CheckTetMesh(result.mesh);
    const auto now = VertexAt(result.mesh);
    uint64_t gone = 0;
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
      if (now.contains(Key(mesh.positions[v]))) continue;
      ++gone;
      EXPECT_TRUE(empty[v]) << "vertex " << v;
    }
    EXPECT_EQ(gone, result.dropped_empty);
    EXPECT_EQ(result.mesh.positions.size() + gone, mesh.positions.size());
    // Four standard deviations of a binomial count.
    const double margin = 4 * std::sqrt(empty_count * share * (1 - share));
    EXPECT_NEAR(double(gone), share * empty_count, margin) << "share " << share;
  }
}

TEST(InsertVertices, LeavesTheCornersWhereAllIsEmpty) {
  const TetMesh mesh = JitteredBox(3);
  const FieldState state = StateOfLogDensity(mesh, [](const glm::vec3&) { return -80.0f; });
  RefineOptions options;
  options.drop_share = 1.0;
  const RefineResult result =
      Refine(mesh, state, std::vector<float>(mesh.tets.size(), 0.0f), options);
  CheckTetMesh(result.mesh);
  EXPECT_EQ(result.mesh.positions.size(), 8u);
  EXPECT_TRUE(std::all_of(result.mesh.positions.begin(), result.mesh.positions.end(), IsCorner));
}

TEST(InsertVertices, SplitsNoEdgeShorterThanTheLeast) {
  const TetMesh mesh = JitteredBox();
  const std::vector<float> error(mesh.tets.size(), 1.0f);
  RefineOptions options = KeepAll();
  options.max_splits_at_vertex = 100;
  options.min_edge = 0.6;  // about twice the spacing: few edges are longer
  const RefineResult result = Refine(mesh, LinearState(mesh), error, options);
  const std::vector<uint32_t> added = NewVertices(mesh, result.mesh);
  ASSERT_GT(added.size(), 5u);
  for (const uint32_t v : added) {
    EXPECT_GE(Length(mesh, EdgeThrough(mesh, result.mesh.positions[v])), 0.6 - 1e-6);
  }
  options.min_edge = 10;  // longer than the box's diagonal
  EXPECT_EQ(Refine(mesh, LinearState(mesh), error, options).split_edges, 0u);
}

TEST(InsertVertices, SplitsNoMoreEdgesAtAVertexThanAllowed) {
  const TetMesh mesh = JitteredBox(5);
  const std::vector<float> error(mesh.tets.size(), 1.0f);
  for (const int most : {1, 3}) {
    RefineOptions options = KeepAll();
    options.max_splits_at_vertex = most;
    const RefineResult result = Refine(mesh, LinearState(mesh), error, options);
    std::vector<int> splits(mesh.positions.size(), 0);
    for (const uint32_t v : NewVertices(mesh, result.mesh)) {
      const Edge edge = EdgeThrough(mesh, result.mesh.positions[v]);
      ++splits[edge.a];
      ++splits[edge.b];
    }
    EXPECT_EQ(*std::max_element(splits.begin(), splits.end()), most);
  }
}

TEST(InsertVertices, GivesTheSameForTheSameSeedOnly) {
  const TetMesh mesh = JitteredBox(5);
  const FieldState state =
      StateOfLogDensity(mesh, [](const glm::vec3& p) { return p.x < 0 ? -20.0f : 2.0f; });
  const std::vector<float> error(mesh.tets.size(), 1.0f);
  RefineOptions options;
  const RefineResult first = Refine(mesh, state, error, options);
  const RefineResult again = Refine(mesh, state, error, options);
  EXPECT_EQ(first.mesh.positions, again.mesh.positions);
  EXPECT_EQ(first.mesh.tets, again.mesh.tets);
  EXPECT_EQ(first.state.parameters, again.state.parameters);
  options.seed = 2;
  EXPECT_NE(first.mesh.positions, Refine(mesh, state, error, options).mesh.positions);
}

TEST(InsertVertices, SplitsNothingWhereThereIsNoError) {
  const TetMesh mesh = JitteredBox(5);
  const FieldState state = LinearState(mesh);
  const RefineResult result =
      Refine(mesh, state, std::vector<float>(mesh.tets.size(), 0.0f), RefineOptions{});
  EXPECT_EQ(result.split_edges, 0u);
  EXPECT_EQ(result.dropped_empty, 0u);
  EXPECT_EQ(result.mesh.positions.size(), mesh.positions.size());
  EXPECT_TRUE(NewVertices(mesh, result.mesh).empty());
}

// A state whose attribute behind the standard ones is linear in space, and so are its moments.
FieldState LinearOther(const TetMesh& mesh, const Attribute& attribute,
                       const std::function<float(const glm::vec3&, int)>& truth) {
  FieldState state;
  state.layout.attributes.push_back(attribute);
  for (const glm::vec3& p : mesh.positions) {
    for (int c = 0; c < state.layout.Components(); ++c) {
      state.parameters.push_back(c < 4 ? 0.5f : truth(p, c));
    }
    for (int c = 0; c < 4; ++c) state.first_moment.push_back(0.1f * truth(p, c));
    for (int c = 0; c < 5; ++c) state.second_moment.push_back(10.0f + truth(p, c));
  }
  return state;
}

TEST(InsertVertices, ReproducesOtherLinearAttributesTooHarmonicsAmongThem) {
  const TetMesh mesh = JitteredBox();
  // No more than 8, for kRounding.
  const auto truth = [](const glm::vec3& p, int c) {
    return 0.25f * float(c % 16) + 2.0f * p.x - p.y + p.z;
  };
  for (const Attribute& attribute :
       {kExtraAttribute, HarmonicsAttribute(1), HarmonicsAttribute(3)}) {
    SCOPED_TRACE(attribute.name + std::to_string(attribute.components));
    const FieldState state = LinearOther(mesh, attribute, truth);
    const RefineResult result =
        Refine(mesh, state, std::vector<float>(mesh.tets.size(), 1.0f), KeepAll());
    EXPECT_GT(result.split_edges, 100u);
    ASSERT_EQ(result.state.layout, state.layout);
    ASSERT_EQ(result.state.rows(), result.mesh.positions.size());
    const int components = state.layout.Components();
    for (size_t at = 0; at < result.state.parameters.size(); ++at) {
      const int c = int(at) % components;
      const float value = truth(result.mesh.positions[at / size_t(components)], c);
      if (c >= 4) {
        EXPECT_NEAR(result.state.parameters[at], value, kRounding);
      }
    }
    ASSERT_EQ(result.state.first_moment.size(), 4 * result.state.rows());
    ASSERT_EQ(result.state.second_moment.size(), 5 * result.state.rows());
    for (size_t row = 0; row < result.state.rows(); ++row) {
      const glm::vec3& place = result.mesh.positions[row];
      for (int c = 0; c < 5; ++c) {
        const float value = truth(place, c);
        EXPECT_NEAR(result.state.second_moment[5 * row + size_t(c)], 10.0f + value, 2 * kRounding);
        if (c == 4) continue;
        EXPECT_NEAR(result.state.first_moment[4 * row + size_t(c)], 0.1f * value, 0.1f * kRounding);
      }
    }
  }
}

// Every row contains the number of its tet.
FieldState NumberedCells(const TetMesh& mesh, float log_density) {
  FieldState state{.layout = {.storage = FieldStorage::kCell}};
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    Append(state, {float(t), 0.0f, 0.0f, log_density}, glm::vec4(-float(t)),
           glm::vec4(2.0f * float(t)));
  }
  return state;
}

double LeastWeight(const TetMesh& mesh, const glm::uvec4& tet, const glm::dvec3& point) {
  double least = 1.0, whole = 0.0;
  for (int i = -1; i < 4; ++i) {
    glm::dvec3 p[4];
    for (int j = 0; j < 4; ++j) p[j] = j == i ? point : glm::dvec3(mesh.positions[tet[j]]);
    const double volume = glm::dot(p[1] - p[0], glm::cross(p[2] - p[0], p[3] - p[0]));
    if (i < 0) {
      whole = volume;
    } else {
      least = std::min(least, volume / whole);
    }
  }
  return least;
}

TEST(InsertVertices, GivesANewCellTheRowOfTheOldOneThatHoldsItsCentroid) {
  const TetMesh mesh = JitteredBox(5);
  const FieldState state = NumberedCells(mesh, 2.0f);
  const RefineResult result =
      Refine(mesh, state, std::vector<float>(mesh.tets.size(), 1.0f), KeepAll());
  EXPECT_GT(result.mesh.tets.size(), mesh.tets.size());
  ASSERT_EQ(result.state.layout, state.layout);
  ASSERT_EQ(result.state.parameters.size(), 4 * result.mesh.tets.size());
  ASSERT_EQ(result.state.first_moment.size(), 4 * result.mesh.tets.size());
  ASSERT_EQ(result.state.second_moment.size(), 4 * result.mesh.tets.size());
  for (size_t t = 0; t < result.mesh.tets.size(); ++t) {
    glm::dvec3 centroid(0.0);
    for (int i = 0; i < 4; ++i) {
      centroid += 0.25 * glm::dvec3(result.mesh.positions[result.mesh.tets[t][i]]);
    }
    const glm::vec4 row = RowOf(result.state.parameters, t);
    ASSERT_GE(LeastWeight(mesh, mesh.tets[size_t(row.r)], centroid), -1e-9) << "tet " << t;
    EXPECT_EQ(row.a, 2.0f);
    EXPECT_EQ(RowOf(result.state.first_moment, t), glm::vec4(-row.r));
    EXPECT_EQ(RowOf(result.state.second_moment, t), glm::vec4(2.0f * row.r));
  }
}

TEST(InsertVertices, LeavesCellsThatStayAsTheyWere) {
  const TetMesh mesh = JitteredBox(5);
  const RefineResult result = Refine(mesh, NumberedCells(mesh, 2.0f),
                                     std::vector<float>(mesh.tets.size(), 0.0f), KeepAll());
  const auto keys = [](const TetMesh& of, size_t t) {
    std::array<std::array<float, 3>, 4> corners;
    for (int i = 0; i < 4; ++i) corners[size_t(i)] = Key(of.positions[of.tets[t][i]]);
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  ASSERT_EQ(result.mesh.tets.size(), mesh.tets.size());
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    EXPECT_EQ(keys(result.mesh, t), keys(mesh, size_t(result.state.parameters[4 * t])));
  }
}

TEST(InsertVertices, DropsVerticesAmongEmptyCells) {
  const TetMesh mesh = JitteredBox(5);
  RefineOptions options;
  options.drop_share = 1.0;
  const RefineResult result = Refine(mesh, NumberedCells(mesh, -80.0f),
                                     std::vector<float>(mesh.tets.size(), 0.0f), options);
  EXPECT_EQ(result.mesh.positions.size(), 8u);
  EXPECT_EQ(result.state.parameters.size(), 4 * result.mesh.tets.size());
}

TEST(InsertVertices, KeepsTheLogarithmFiniteWhereThereIsNoDensity) {
  const TetMesh mesh = JitteredBox(4);
  // exp(-200) is 0 as a float.
  const FieldState state = StateOfLogDensity(mesh, [](const glm::vec3&) { return -200.0f; });
  const RefineResult result =
      Refine(mesh, state, std::vector<float>(mesh.tets.size(), 1.0f), KeepAll());
  EXPECT_GT(result.split_edges, 0u);
  for (const uint32_t v : NewVertices(mesh, result.mesh)) {
    const float log_density = result.state.parameters[4 * v + 3];
    EXPECT_TRUE(std::isfinite(log_density));
    EXPECT_LT(log_density, -79.0f);
  }
}

}  // namespace
}  // namespace tetrec
