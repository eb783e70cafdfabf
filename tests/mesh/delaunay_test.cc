#include "mesh/delaunay.h"

#include "core/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>

namespace tetrec {
namespace {

std::vector<glm::vec3> RandomPoints(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<glm::vec3> points;
  for (int i = 0; i < count; ++i) {
    const float x = unit(random), y = unit(random), z = unit(random);
    points.emplace_back(x, y, z);
  }
  return points;
}

void AppendCorners(std::vector<glm::vec3>& points, float half_side) {
  for (int i = 0; i < 8; ++i) {
    points.push_back(half_side * glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  }
}

// Sign of the insphere determinant in long double; 0 if rounding could change it.
int InSphere(const TetMesh& mesh, const glm::uvec4& tet, const glm::vec3& q) {
  long double m[4][4];
  for (int i = 0; i < 4; ++i) {
    m[i][3] = 0;
    for (int k = 0; k < 3; ++k) {
      m[i][k] = static_cast<long double>(mesh.positions[tet[i]][k]) - q[k];
      m[i][3] += m[i][k] * m[i][k];
    }
  }
  const auto det3 = [&](int a, int b, int c) {
    return m[a][0] * (m[b][1] * m[c][2] - m[b][2] * m[c][1]) -
           m[a][1] * (m[b][0] * m[c][2] - m[b][2] * m[c][0]) +
           m[a][2] * (m[b][0] * m[c][1] - m[b][1] * m[c][0]);
  };
  const long double value = m[0][3] * det3(1, 2, 3) - m[1][3] * det3(0, 2, 3) +
                            m[2][3] * det3(0, 1, 3) - m[3][3] * det3(0, 1, 2);
  if (std::abs(value) < 1e-15L) return 0;
  return value > 0 ? 1 : -1;
}

TEST(BuildDelaunay, FillsTheBoxOfItsCorners) {
  std::vector<glm::vec3> points = RandomPoints(2000, 1);
  AppendCorners(points, 2);
  const DelaunayResult result = BuildDelaunay(points);
  CheckTetMesh(result.mesh);
  const TetMeshQuality quality = MeasureQuality(result.mesh);
  EXPECT_NEAR(quality.total_volume, 64, 64e-12);  // sum of 13,000 doubles, each right to 1e-15
  EXPECT_EQ(quality.boundary_faces, 12u);
  EXPECT_EQ(result.mesh.positions.size(), points.size());
}

TEST(BuildDelaunay, NamesTheInputPointOfEachVertex) {
  const std::vector<glm::vec3> points = RandomPoints(500, 2);
  const DelaunayResult result = BuildDelaunay(points);
  ASSERT_EQ(result.point_of_vertex.size(), 500u);
  for (size_t v = 0; v < 500; ++v) {
    EXPECT_EQ(result.mesh.positions[v], points[result.point_of_vertex[v]]);
  }
}

TEST(BuildDelaunay, LeavesEveryCircumsphereEmpty) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const DelaunayResult result = BuildDelaunay(RandomPoints(60, seed));
    for (const glm::uvec4& tet : result.mesh.tets) {
      for (uint32_t v = 0; v < result.mesh.positions.size(); ++v) {
        if (v == tet[0] || v == tet[1] || v == tet[2] || v == tet[3]) continue;
        // For a positively oriented tet the determinant is negative inside the sphere.
        ASSERT_GE(
            InSphere(result.mesh, tet, result.mesh.positions[v]) *
                -InSphere(result.mesh, tet,
                          0.25f * (result.mesh.positions[tet[0]] + result.mesh.positions[tet[1]] +
                                   result.mesh.positions[tet[2]] + result.mesh.positions[tet[3]])),
            0)
            << "seed " << seed << " vertex " << v;
      }
    }
  }
}

TEST(BuildDelaunay, KeepsTheFirstOfEqualPoints) {
  std::vector<glm::vec3> points = RandomPoints(300, 3);
  const std::vector<glm::vec3> again = points;
  points.insert(points.end(), again.rbegin(), again.rend());
  const DelaunayResult result = BuildDelaunay(points);
  CheckTetMesh(result.mesh);
  ASSERT_EQ(result.point_of_vertex.size(), 300u);
  EXPECT_LT(*std::max_element(result.point_of_vertex.begin(), result.point_of_vertex.end()), 300u);
}

TEST(BuildDelaunay, TakesCosphericalGrids) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < 1000; ++i) points.emplace_back(i % 10, i / 10 % 10, i / 100);
  const DelaunayResult result = BuildDelaunay(points);
  CheckTetMesh(result.mesh);
  EXPECT_NEAR(MeasureQuality(result.mesh).total_volume, 729, 729e-12);
}

TEST(BuildDelaunay, GivesTheSameMeshTwice) {
  const std::vector<glm::vec3> points = RandomPoints(3000, 4);
  const DelaunayResult a = BuildDelaunay(points), b = BuildDelaunay(points);
  EXPECT_EQ(a.mesh.positions, b.mesh.positions);
  EXPECT_EQ(a.mesh.tets, b.mesh.tets);
  EXPECT_EQ(a.mesh.neighbors, b.mesh.neighbors);
}

TEST(BuildDelaunay, RefusesPointsWithoutVolume) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  std::vector<glm::vec3> points = RandomPoints(10, 5);
  EXPECT_THROW(BuildDelaunay(std::span(points).first(3)), DataError);
  for (const float bad : {nan, infinity, -infinity}) {
    std::vector<glm::vec3> hostile = points;
    hostile[7].y = bad;
    EXPECT_THROW(BuildDelaunay(hostile), DataError);
  }
  for (glm::vec3& p : points) p.z = 0.1f;
  EXPECT_THROW(BuildDelaunay(points), DataError);
  EXPECT_THROW(BuildDelaunay(std::vector<glm::vec3>(20, glm::vec3(1, 2, 3))), DataError);
  EXPECT_THROW(BuildDelaunay({}), DataError);
}

TEST(BuildDelaunay, TakesHugeAndTinyCoordinates) {
  for (const float scale : {1e-30f, 1e30f}) {
    std::vector<glm::vec3> points = RandomPoints(100, 6);
    for (glm::vec3& p : points) p *= scale;
    EXPECT_NO_THROW(CheckTetMesh(BuildDelaunay(points).mesh)) << scale;
  }
}

}  // namespace
}  // namespace tetrec
