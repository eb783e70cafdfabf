#include "refine/collapse.h"

#include "mesh/boundary.h"
#include "refine/refined_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace tetrec {
namespace {

// Grey and density as functions of the place.
FieldState StateOfValues(const TetMesh& mesh, const std::function<float(const glm::vec3&)>& grey,
                         const std::function<float(const glm::vec3&)>& density) {
  FieldState state = RandomState(mesh, FieldStorage::kVertex);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::vec3& p = mesh.positions[v];
    for (size_t c = 0; c < 3; ++c) state.parameters[4 * v + c] = grey(p);
    state.parameters[4 * v + 3] = std::log(density(p));
  }
  return state;
}

RefineScores ScoresOfLight(const TetMesh& mesh, float light, double squared_error = 1.0) {
  RefineScores scores;
  scores.of_tets.assign(mesh.tets.size(), 1.0f);
  scores.squared_error = squared_error;
  scores.visible_of_tets.assign(mesh.tets.size(), light);
  return scores;
}

// A mesh that loses vertices and gains none.
RefineResult Coarsened(const TetMesh& mesh, const FieldState& state, const RefineScores& scores,
                       double flat_error = 0.01) {
  RefineOptions options;
  options.scheme = RefineScheme::kHalve;
  options.growth = 0;
  options.flat_error = flat_error;
  return Refine(mesh, state, scores, options);
}

uint64_t OnBoundary(const TetMesh& mesh) {
  const std::vector<uint8_t> flags = BoundaryVertices(mesh);
  return uint64_t(std::ranges::count(flags, 1));
}

TEST(CollapseSpare, LeavesASoundMeshInManyRandomCases) {
  for (uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    const TetMesh mesh = seed % 3 ? JitteredBox(5, seed) : GridBox(6);
    const FieldState state = RandomState(mesh, FieldStorage::kVertex, seed);
    RefineScores scores = RandomScores(mesh, seed);
    scores.visible_of_tets = scores.of_tets;
    scores.squared_error = 1e9;
    const RefineResult result = Coarsened(mesh, state, scores);
    ExpectSoundBox(result.mesh);
    EXPECT_EQ(result.mesh.positions.size(),
              mesh.positions.size() - result.dropped_empty - result.dropped_flat);
    const uint64_t inside = mesh.positions.size() - OnBoundary(mesh);
    EXPECT_GT(double(result.dropped_flat), 0.3 * double(inside));
  }
}

// Vertices that stay have their rows, those of the moments included.
TEST(CollapseSpare, KeepsTheRowsOfTheVerticesThatAreLeft) {
  const TetMesh mesh = JitteredBox(5);
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  const RefineResult result = Coarsened(mesh, state, ScoresOfLight(mesh, 1.0f), 30);
  ASSERT_GT(result.dropped_flat, 20u);
  ASSERT_TRUE(result.of_vertices.inserted.empty());
  for (size_t v = 0; v < result.mesh.positions.size(); ++v) {
    const size_t old = result.of_vertices.kept[v];
    EXPECT_EQ(result.mesh.positions[v], mesh.positions[old]);
    for (size_t c = 0; c < 4; ++c) {
      EXPECT_EQ(result.state.parameters[4 * v + c], state.parameters[4 * old + c]);
      EXPECT_EQ(result.state.first_moment[4 * v + c], state.first_moment[4 * old + c]);
    }
  }
}

// The values of an affine field are the same wherever its vertices are.
TEST(CollapseSpare, LeavesAnAffineFieldAsItIs) {
  const TetMesh mesh = JitteredBox();
  FieldState state = StateOfValues(
      mesh, [](const glm::vec3& p) { return 0.5f + 0.1f * p.x - 0.2f * p.y; },
      [](const glm::vec3& p) { return 3.0f + p.z; });
  const RefineResult result = Coarsened(mesh, state, ScoresOfLight(mesh, 1.0f));
  EXPECT_GT(2 * result.dropped_flat, mesh.positions.size());
  ExpectSameField(mesh, state, result.mesh, result.state);
}

TEST(CollapseSpare, TakesMostVerticesAroundWhichNoRayLosesLight) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = StateOfValues(
      mesh, [](const glm::vec3&) { return 0.5f; }, [](const glm::vec3&) { return 1e-3f; });
  RefineScores scores = ScoresOfLight(mesh, 1.0f, 0.0);
  std::vector<uint8_t> is_seen(mesh.positions.size(), 0);
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    if (mesh.positions[mesh.tets[t][0]].x > 0.0f) {
      for (int i = 0; i < 4; ++i) is_seen[mesh.tets[t][i]] = 1;
    } else {
      scores.visible_of_tets[t] = 0.0f;
    }
  }
  const FieldState noisy = [&] {
    FieldState result = state;
    const FieldState noise = RandomState(mesh, FieldStorage::kVertex);
    for (size_t i = 0; i < result.parameters.size(); i += 4) {
      result.parameters[i] = noise.parameters[i];
    }
    return result;
  }();
  const RefineResult result = Coarsened(mesh, noisy, scores);
  const uint64_t empty = uint64_t(std::ranges::count(is_seen, 0)) - 4;  // corners of the box stay
  EXPECT_GT(result.dropped_empty, empty * 8 / 10);
  EXPECT_LE(result.dropped_empty, empty);
  EXPECT_EQ(result.dropped_flat, 0u);
  for (size_t v = 0; v < is_seen.size(); ++v) {
    const bool is_left = std::ranges::count(result.of_vertices.kept, uint32_t(v)) == 1;
    if (is_seen[v]) {
      EXPECT_TRUE(is_left) << "vertex " << v;
    }
  }
}

TEST(CollapseSpare, LeavesVerticesThatMustStay) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  RefineScores scores = ScoresOfLight(mesh, 0.0f);
  for (const glm::vec3& p : mesh.positions) scores.is_kept.push_back(p.x > 0.0f);
  const RefineResult result = Coarsened(mesh, state, scores);
  EXPECT_GT(result.dropped_empty, 50u);
  const uint64_t kept = uint64_t(
      std::ranges::count_if(result.mesh.positions, [](const glm::vec3& p) { return p.x > 0.0f; }));
  EXPECT_EQ(kept, uint64_t(std::ranges::count(scores.is_kept, 1)));
}

// Between a wall and clear space, vertices of the clear side keep the wall in its place.
TEST(CollapseSpare, KeepsClearSpaceClear) {
  const TetMesh mesh = JitteredBox(9);
  const FieldState state = StateOfValues(
      mesh, [](const glm::vec3&) { return 0.5f; },
      [](const glm::vec3& p) { return p.x > 0.5f ? 1000.0f : 1e-3f; });
  const RefineResult result = Coarsened(mesh, state, ScoresOfLight(mesh, 0.0f));
  EXPECT_GT(result.dropped_empty, 100u);
  Random random(2);
  int clear = 0, darkened = 0;
  for (int i = 0; i < 1000; ++i) {
    glm::dvec3 point;
    for (int k = 0; k < 3; ++k) point[k] = 1.9 * random.Uniform() - 0.95;
    if (!(ValueAt(mesh, state, point).a < 0.1)) continue;
    ++clear;
    darkened += ValueAt(result.mesh, result.state, point).a > 5;
  }
  // Without the check, nearly all of them.
  EXPECT_LT(darkened, clear / 20);
}

// More error affords more vertices.
TEST(CollapseSpare, CostsNoMoreThanTheGivenShareOfTheError) {
  const TetMesh mesh = JitteredBox();
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  uint64_t before = 0;
  for (const double share : {0.0, 1.0, 30.0}) {
    const RefineResult result = Coarsened(mesh, state, ScoresOfLight(mesh, 1.0f), share);
    EXPECT_GE(result.dropped_flat, before + uint64_t(share)) << share;
    before = result.dropped_flat;
    if (share == 0.0) {
      EXPECT_EQ(result.dropped_flat, 0u);
    }
  }
}

// The half with noise is needed more than the flat one.
TEST(CollapseSpare, TakesFirstWhatIsNeededLeast) {
  const TetMesh mesh = JitteredBox();
  FieldState state = StateOfValues(
      mesh, [](const glm::vec3&) { return 0.5f; }, [](const glm::vec3&) { return 3.0f; });
  const FieldState noise = RandomState(mesh, FieldStorage::kVertex);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (mesh.positions[v].x > 0) state.parameters[4 * v] = noise.parameters[4 * v];
  }
  const RefineResult result = Coarsened(mesh, state, ScoresOfLight(mesh, 1.0f), 1.0);
  uint64_t noisy_left = 0, noisy = 0;
  for (const glm::vec3& p : result.mesh.positions) noisy_left += p.x > 0;
  for (const glm::vec3& p : mesh.positions) noisy += p.x > 0;
  EXPECT_GT(result.dropped_flat, mesh.positions.size() / 6);
  EXPECT_LT(double(noisy - noisy_left), 0.15 * double(result.dropped_flat));
}

}  // namespace
}  // namespace tetrec
