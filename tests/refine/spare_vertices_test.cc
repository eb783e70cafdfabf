#include "refine/spare_vertices.h"

#include "refine/refined_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace tetrec {
namespace {

// Grey 0.5 + bump(p), of density 3 + p.x.
FieldState StateOfBump(const TetMesh& mesh, const std::function<float(const glm::vec3&)>& bump) {
  FieldState state = RandomState(mesh, FieldStorage::kVertex);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::vec3& p = mesh.positions[v];
    for (size_t c = 0; c < 3; ++c) state.parameters[4 * v + c] = 0.5f + bump(p);
    state.parameters[4 * v + 3] = std::log(3.0f + p.x);
  }
  return state;
}

RefineScores Scores(const TetMesh& mesh, float error, float light) {
  RefineScores scores;
  scores.of_tets.assign(mesh.tets.size(), error);
  scores.squared_error = double(error) * double(mesh.tets.size());
  scores.visible_of_tets.assign(mesh.tets.size(), light);
  return scores;
}

RefineOptions DropAll() {
  RefineOptions options;
  options.drop_share = 1.0;
  return options;
}

TEST(SpareVertices, AreThoseAroundWhichNoRayLosesLight) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  RefineScores scores = Scores(mesh, 1e-6f, 0.0f);
  std::vector<uint8_t> is_seen(mesh.positions.size(), 0);
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    if (!(mesh.positions[mesh.tets[t][0]].x > 0.0f)) continue;
    scores.visible_of_tets[t] = 1.0f;
    for (int i = 0; i < 4; ++i) is_seen[mesh.tets[t][i]] = 1;
  }
  const SpareVertices spare = FindSpareVertices(mesh, state, scores, DropAll());
  uint64_t empty = 0;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const bool expected = !is_seen[v] && !IsCorner(mesh.positions[v]);
    EXPECT_EQ(spare.is_spare[v] != 0, expected) << "vertex " << v;
    empty += expected;
  }
  EXPECT_GT(empty, 50u);
  EXPECT_EQ(spare.empty, empty);
  EXPECT_EQ(spare.flat, 0u);
}

TEST(SpareVertices, AreNotThoseThatMustStay) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  RefineScores scores = Scores(mesh, 1e-6f, 0.0f);
  const uint64_t all = FindSpareVertices(mesh, state, scores, DropAll()).empty;
  for (const glm::vec3& p : mesh.positions) scores.is_kept.push_back(p.x > 0.0f);
  const SpareVertices spare = FindSpareVertices(mesh, state, scores, DropAll());
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    EXPECT_FALSE(spare.is_spare[v] && scores.is_kept[v]);
  }
  EXPECT_GT(spare.empty, 0u);
  EXPECT_LT(spare.empty, all);
}

// An affine field is what the neighbours predict, up to the rounding of float.
TEST(SpareVertices, OfAnAffineFieldAreFlatAndNoNeighbours) {
  const TetMesh mesh = JitteredBox();
  const FieldState state =
      StateOfBump(mesh, [](const glm::vec3& p) { return 0.1f * p.x - 0.2f * p.y + 0.1f * p.z; });
  const SpareVertices spare = FindSpareVertices(mesh, state, Scores(mesh, 1e-4f, 1.0f), DropAll());
  EXPECT_GT(spare.flat, mesh.positions.size() / 20);
  EXPECT_EQ(spare.empty, 0u);
  for (const glm::uvec4& tet : mesh.tets) {
    int count = 0;
    for (int i = 0; i < 4; ++i) count += spare.is_spare[tet[i]];
    EXPECT_LE(count, 1);
  }
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    EXPECT_FALSE(spare.is_spare[v] && IsCorner(mesh.positions[v]));
  }
}

TEST(SpareVertices, AreNotWhereTheFieldBends) {
  const TetMesh mesh = JitteredBox(9);
  const FieldState state = StateOfBump(
      mesh, [](const glm::vec3& p) { return p.x < 0.0f ? 0.0f : 0.3f * std::sin(20 * p.y); });
  const SpareVertices spare = FindSpareVertices(mesh, state, Scores(mesh, 1e-4f, 1.0f), DropAll());
  uint64_t where_flat = 0, where_bent = 0;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (!spare.is_spare[v]) continue;
    where_flat += mesh.positions[v].x < -0.2f;
    where_bent += mesh.positions[v].x > 0.2f;  // by chance: waves cross what is predicted
  }
  EXPECT_GT(where_flat, 20u);
  EXPECT_LT(5 * where_bent, where_flat);
}

TEST(SpareVertices, MayCostNoMoreThanTheGivenShareOfTheError) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  RefineOptions options = DropAll();
  uint64_t before = 0;
  for (const double share : {0.0, 0.01, 0.1}) {
    options.flat_error = share;
    const SpareVertices spare = FindSpareVertices(mesh, state, Scores(mesh, 1.0f, 1.0f), options);
    EXPECT_GE(spare.flat, before);
    before = spare.flat;
    if (share == 0.0) {
      EXPECT_EQ(spare.flat, 0u);
    }
  }
  EXPECT_GT(before, 0u);
}

TEST(SpareVertices, LeaveAWholeMesh) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = StateOfBump(mesh, [](const glm::vec3& p) { return 0.1f * p.y; });
  const RefineResult result = Refine(mesh, state, Scores(mesh, 1e-4f, 1.0f), DropAll());
  EXPECT_GT(result.dropped_flat, 0u);
  EXPECT_NO_THROW(CheckTetMesh(result.mesh));
  EXPECT_NO_THROW(CheckConvexDomain(result.mesh));
  EXPECT_EQ(MeasureQuality(result.mesh).boundary_faces, 12u);
}

RefineOptions KeepShare(double share) {
  RefineOptions options = DropAll();
  options.kept_share = share;
  return options;
}

TEST(SpareVertices, AreAsManyAsAShareOfTheMeshAsks) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  const SpareVertices spare =
      FindSpareVertices(mesh, state, Scores(mesh, 1e-9f, 1.0f), KeepShare(0.5));
  EXPECT_EQ(spare.empty, 0u);
  EXPECT_EQ(spare.flat, mesh.positions.size() / 2);
  EXPECT_EQ(std::ranges::count(spare.is_spare, 1), std::ptrdiff_t(spare.flat));
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    EXPECT_FALSE(spare.is_spare[v] && IsCorner(mesh.positions[v]));
  }
}

// The half with noise is needed more than the flat one.
TEST(SpareVertices, AreFirstThoseThatAreNeededLeast) {
  const TetMesh mesh = JitteredBox();
  FieldState state = StateOfBump(mesh, [](const glm::vec3&) { return 0.0f; });
  const FieldState noise = RandomState(mesh, FieldStorage::kVertex);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (mesh.positions[v].x > 0) state.parameters[4 * v] = noise.parameters[4 * v];
  }
  const SpareVertices spare =
      FindSpareVertices(mesh, state, Scores(mesh, 1e-9f, 1.0f), KeepShare(0.8));
  uint64_t flat = 0;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    flat += spare.is_spare[v] && mesh.positions[v].x <= 0;
  }
  EXPECT_GT(double(flat), 0.9 * double(spare.flat));
}

}  // namespace
}  // namespace tetrec
