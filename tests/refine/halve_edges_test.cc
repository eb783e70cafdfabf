#include "refine/halve_edges.h"

#include "refine/refined_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace tetrec {
namespace {

RefineOptions HalveOptions(double growth) {
  RefineOptions options;
  options.scheme = RefineScheme::kHalve;
  options.growth = growth;
  return options;
}

RefineScores NoScores(const TetMesh& mesh) {
  RefineScores scores;
  scores.of_tets.assign(mesh.tets.size(), 0.0f);
  return scores;
}

TEST(HalveEdges, KeepsMeshAndFieldSoundInManyRandomCases) {
  for (uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    const TetMesh mesh = seed % 3 ? JitteredBox(5, seed) : GridBox(6);
    const FieldStorage storage = seed % 4 == 3 ? FieldStorage::kCell : FieldStorage::kVertex;
    const FieldState state = RandomState(mesh, storage, seed);
    const RefineResult result = Refine(mesh, state, RandomScores(mesh, seed), HalveOptions(3));
    EXPECT_GT(result.split_edges, mesh.positions.size() / 8);
    EXPECT_EQ(result.mesh.positions.size(), mesh.positions.size() + result.split_edges);
    ExpectSoundBox(result.mesh);
    ExpectSameField(mesh, state, result.mesh, result.state);
  }
}

TEST(HalveEdges, CutsOnlyTetsAroundAnEdgeOfATetWithAScore) {
  const TetMesh mesh = JitteredBox(5);
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  for (size_t worst = 0; worst < mesh.tets.size(); worst += 31) {
    RefineScores scores = NoScores(mesh);
    scores.of_tets[worst] = 1.0f;
    const Refinement result = HalveEdges(mesh, state, scores, HalveOptions(2));
    ASSERT_LE(result.split_edges, 1u);
    if (result.split_edges == 0) continue;  // all of its edges are between corners of the box
    const auto [a, b, share] = result.of_vertices.inserted[0];
    for (const uint32_t end : {a, b}) {
      EXPECT_EQ(std::ranges::count_if(std::array{0, 1, 2, 3},
                                      [&](int i) { return mesh.tets[worst][i] == end; }),
                1);
    }
    EXPECT_EQ(std::ranges::count(result.old_tets, uint32_t(worst)), 2);
  }
}

TEST(HalveEdges, PrefersLongEdgesOfTheWorstTets) {
  const TetMesh mesh = JitteredBox(5);
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  RefineScores scores = NoScores(mesh);
  scores.of_tets.assign(mesh.tets.size(), 1.0f);
  RefineOptions options = HalveOptions(2);
  options.max_vertices = mesh.positions.size() + 10;
  const Refinement longest = HalveEdges(mesh, state, scores, options);
  ASSERT_EQ(longest.split_edges, 10u);
  const auto length = [&](const RowSource& edge) {
    return glm::distance(mesh.positions[edge.a], mesh.positions[edge.b]);
  };
  for (size_t i = 1; i < 10; ++i) {
    EXPECT_LE(length(longest.of_vertices.inserted[i]),
              length(longest.of_vertices.inserted[i - 1]) * 1.0001f);
  }
}

TEST(HalveEdges, SplitsNoShortEdgeAndFewAtOneVertex) {
  const TetMesh mesh = JitteredBox(5);
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  RefineOptions options = HalveOptions(10);
  options.min_edge = 10;
  EXPECT_EQ(HalveEdges(mesh, state, RandomScores(mesh), options).split_edges, 0u);
  options = HalveOptions(10);
  options.max_splits_at_vertex = 1;
  const Refinement result = HalveEdges(mesh, state, RandomScores(mesh), options);
  EXPECT_GT(result.split_edges, 10u);
  std::vector<int> splits(mesh.positions.size(), 0);
  for (const auto& [a, b, share] : result.of_vertices.inserted) {
    EXPECT_LE(++splits[a], 1);
    EXPECT_LE(++splits[b], 1);
  }
}

// Half of the box is empty.
TEST(HalveEdges, PutsVerticesWhereTheyAreNeededInsteadOfWhereTheyAreNot) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  RefineScores scores = RandomScores(mesh);
  scores.squared_error = 1e-9;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    const bool is_empty = mesh.positions[mesh.tets[t][0]].x < -0.3f;
    scores.visible_of_tets.push_back(is_empty ? 0.0f : 1.0f);
    if (is_empty) scores.of_tets[t] = 0.0f;
  }
  const RefineResult result = Refine(mesh, state, scores, HalveOptions(1));
  EXPECT_GT(result.dropped_empty, 10u);
  EXPECT_EQ(result.split_edges, result.dropped_empty + result.dropped_flat);
  EXPECT_EQ(result.mesh.positions.size(), mesh.positions.size());
  ExpectSoundBox(result.mesh);
}

}  // namespace
}  // namespace tetrec
