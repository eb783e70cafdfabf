#include "refine/darkened.h"

#include "refine/insert_vertices.h"
#include "refine/refined_box.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

constexpr float kDense = 40.0f, kClear = 1e-4f;

// A dense ball in clear space.
std::vector<float> BallDensities(const TetMesh& mesh) {
  std::vector<float> values;
  for (const glm::vec3& p : mesh.positions) {
    values.push_back(glm::length(p) < 0.5f ? kDense : kClear);
  }
  return values;
}

// With these densities and colours that are linear in space.
FieldState StateOf(const TetMesh& mesh, const std::vector<float>& densities) {
  FieldState state = RandomState(mesh, FieldStorage::kVertex);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    for (int c = 0; c < 3; ++c) {
      state.parameters[4 * v + size_t(c)] = 0.5f + 0.3f * mesh.positions[v][c];
    }
    state.parameters[4 * v + 3] = std::log(densities[v]);
  }
  return state;
}

// What a mesh becomes without some of its vertices.
struct Rest {
  TetMesh mesh;
  Prolongation of_vertices;
};
Rest Without(const TetMesh& mesh, const std::vector<uint32_t>& gone) {
  std::vector<glm::vec3> points;
  std::vector<uint32_t> rows;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (std::ranges::binary_search(gone, v)) continue;
    points.push_back(mesh.positions[v]);
    rows.push_back(v);
  }
  DelaunayResult delaunay = BuildDelaunay(points);
  Rest rest{std::move(delaunay.mesh), {}};
  for (const uint32_t point : delaunay.point_of_vertex) {
    rest.of_vertices.kept.push_back(rows[point]);
  }
  return rest;
}

// All vertices that are clear, but the corners.
std::vector<uint32_t> ClearVertices(const TetMesh& mesh, const std::vector<float>& densities) {
  std::vector<uint32_t> clear;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    if (densities[v] == kClear && !IsCorner(mesh.positions[v])) clear.push_back(v);
  }
  return clear;
}

TEST(Darkened, AreVerticesWhosePlaceIsOpaqueWithoutThem) {
  const TetMesh mesh = JitteredBox();
  const std::vector<float> densities = BallDensities(mesh);
  // On one side of the ball all, on the other side some, among clear ones.
  std::vector<uint32_t> gone = ClearVertices(mesh, densities);
  std::erase_if(gone, [&](uint32_t v) { return mesh.positions[v].x < 0.2f && v % 4 != 0; });
  const Rest rest = Without(mesh, gone);
  const DarkenedPlaces darkened = FindDarkened(mesh, densities, gone, rest.mesh, rest.of_vertices);
  const FieldState state = StateOf(rest.mesh, Prolong(densities, rest.of_vertices));
  size_t clear = 0;
  for (const uint32_t v : gone) {
    const double density = ValueAt(rest.mesh, state, glm::dvec3(mesh.positions[v])).a;
    const bool is_darkened = std::ranges::count(darkened.vertices, v) > 0;
    // Edges around a vertex of the box are from 0.1 to 1 long in the mean.
    if (density < 0.3) {
      EXPECT_FALSE(is_darkened) << "vertex " << v << ", density " << density;
      ++clear;
    } else if (density * 0.1 > 0.4) {
      EXPECT_TRUE(is_darkened) << "vertex " << v << ", density " << density;
    }
  }
  EXPECT_GT(darkened.vertices.size(), 50u);
  EXPECT_GT(clear, 20u);
}

TEST(Darkened, PlacesAreClearInTheOldMeshAndOpaqueInTheNewOne) {
  const TetMesh mesh = JitteredBox();
  const std::vector<float> densities = BallDensities(mesh);
  const std::vector<uint32_t> gone = ClearVertices(mesh, densities);
  const Rest rest = Without(mesh, gone);
  const DarkenedPlaces darkened = FindDarkened(mesh, densities, gone, rest.mesh, rest.of_vertices);
  const FieldState was = StateOf(mesh, densities);
  const FieldState is = StateOf(rest.mesh, Prolong(densities, rest.of_vertices));
  ASSERT_GT(darkened.places.size(), 20u);
  for (const PlaceInTet& place : darkened.places) {
    const glm::dvec3 point(place.position);
    EXPECT_GT(ValueAt(rest.mesh, is, point).a, ValueAt(mesh, was, point).a + 0.1);
    glm::dvec3 mean(0.0);
    for (int i = 0; i < 4; ++i) {
      EXPECT_GE(place.weights[i], 0.0);
      mean += place.weights[i] * glm::dvec3(mesh.positions[place.vertices[i]]);
    }
    EXPECT_LT(glm::distance(mean, point), 1e-6);
  }
}

TEST(Darkened, IsNothingInTheSameMeshOrInALinearField) {
  const TetMesh mesh = JitteredBox();
  const Rest same = Without(mesh, {});
  const DarkenedPlaces of_ball =
      FindDarkened(mesh, BallDensities(mesh), {}, same.mesh, same.of_vertices);
  EXPECT_TRUE(of_ball.vertices.empty());
  EXPECT_TRUE(of_ball.places.empty());

  std::vector<float> linear;
  for (const glm::vec3& p : mesh.positions) linear.push_back(20.0f + 10.0f * p.x - 5.0f * p.z);
  const std::vector<uint32_t> gone = ClearVertices(mesh, BallDensities(mesh));
  const Rest rest = Without(mesh, gone);
  const DarkenedPlaces of_linear = FindDarkened(mesh, linear, gone, rest.mesh, rest.of_vertices);
  EXPECT_TRUE(of_linear.vertices.empty());
  EXPECT_TRUE(of_linear.places.empty());
}

// The share of random points in space that was clear around a ball and is not any more.
double DarkenedShare(const TetMesh& before, const FieldState& state_before, const TetMesh& after,
                     const FieldState& state_after) {
  Random random(7);
  int clear = 0, darkened = 0;
  for (int i = 0; i < 4000; ++i) {
    glm::dvec3 point;
    for (int k = 0; k < 3; ++k) point[k] = 1.99 * random.Uniform() - 0.995;
    if (ValueAt(before, state_before, point).a > 2 * double(kClear)) continue;
    ++clear;
    darkened += ValueAt(after, state_after, point).a > 1;
  }
  EXPECT_GT(clear, 1000);
  return double(darkened) / double(clear);
}

// Rays lose light only in the ball, so that all clear vertices seem to be spare.
TEST(Darkened, PlacesAreMendedByARefinement) {
  const TetMesh mesh = JitteredBox(14);
  const std::vector<float> densities = BallDensities(mesh);
  const FieldState state = StateOf(mesh, densities);
  RefineScores scores;
  scores.of_tets.assign(mesh.tets.size(), 0.0f);
  for (const glm::uvec4& tet : mesh.tets) {
    bool is_inside = true;
    for (int i = 0; i < 4; ++i) is_inside = is_inside && densities[tet[i]] == kDense;
    scores.visible_of_tets.push_back(is_inside ? 1.0f : 0.0f);
  }
  RefineOptions options;
  options.max_vertices = mesh.positions.size() + 10;
  options.growth = 1.2;
  options.flat_error = 0.0;
  const RefineResult result = Refine(mesh, state, scores, options);
  ExpectSoundBox(result.mesh);
  EXPECT_GT(result.put_back, 50u);
  EXPECT_GT(result.patches, 0u);
  EXPECT_LE(result.mesh.positions.size(), options.max_vertices);
  // The new vertices have the values of the old field.
  for (size_t v = 0; v < result.mesh.positions.size(); ++v) {
    const glm::dvec4 was = ValueAt(mesh, state, glm::dvec3(result.mesh.positions[v]));
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(double(result.state.parameters[4 * v + size_t(c)]), was[c], 1e-5);
    }
    EXPECT_NEAR(double(std::exp(result.state.parameters[4 * v + 3])), was.a, 1e-3 * kDense);
  }

  std::vector<uint32_t> gone = ClearVertices(mesh, densities);
  const Rest unmended = Without(mesh, gone);
  const FieldState unmended_state =
      StateOf(unmended.mesh, Prolong(densities, unmended.of_vertices));
  const double share = DarkenedShare(mesh, state, result.mesh, result.state);
  EXPECT_LT(share, 0.5 * DarkenedShare(mesh, state, unmended.mesh, unmended_state));
}

}  // namespace
}  // namespace tetrec
