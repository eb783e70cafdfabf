#include "refine/prism.h"

#include "core/random.h"
#include "refine/refined_box.h"

#include <gtest/gtest.h>

#include <map>
#include <numeric>
#include <string>

namespace tetrec {
namespace {

// The bottoms around each vertex of a mesh that is not on its boundary, or is, in ids of vertices.
std::vector<std::vector<glm::uvec3>> BottomsOfStars(const TetMesh& mesh) {
  std::vector<std::vector<glm::uvec3>> stars(mesh.positions.size());
  for (const glm::uvec4& tet : mesh.tets) {
    stars[tet[0]].push_back({tet[1], tet[2], tet[3]});
    stars[tet[1]].push_back({tet[0], tet[3], tet[2]});
    stars[tet[2]].push_back({tet[3], tet[0], tet[1]});
    stars[tet[3]].push_back({tet[2], tet[1], tet[0]});
  }
  return stars;
}

void ExpectCompatible(const std::vector<glm::uvec3>& bottoms,
                      const std::vector<PrismPattern>& patterns) {
  ASSERT_EQ(patterns.size(), bottoms.size());
  const auto opposite = OppositeQuads(bottoms);
  for (size_t p = 0; p < bottoms.size(); ++p) {
    EXPECT_TRUE(CanBeCut(patterns[p])) << "prism " << p;
    for (size_t k = 0; k < 3; ++k) {
      const PrismQuad& other = opposite[p][k];
      if (other.prism == kNoPrism) continue;
      EXPECT_NE(patterns[p] >> k & 1, patterns[other.prism] >> other.k & 1)
          << "prisms " << p << " and " << other.prism;
    }
  }
}

TEST(CutPrism, GivesThreePositiveTetsOfKnownVolumesForEveryPattern) {
  // Bottom, then top; above the top is (0, 0, 1).
  const std::vector<glm::dvec3> corners = {{0, 0, 0},   {0, 1, 0},     {1, 0, 0},
                                           {0, 0, 0.5}, {0, 0.5, 0.5}, {0.5, 0, 0.5}};
  for (PrismPattern pattern = 1; pattern < 7; ++pattern) {
    const auto tets = CutPrism({0, 1, 2}, {3, 4, 5}, pattern);
    std::vector<double> volumes;
    for (const glm::uvec4& tet : tets) {
      const glm::dvec3 origin = corners[tet[0]];
      volumes.push_back(glm::dot(corners[tet[1]] - origin,
                                 glm::cross(corners[tet[2]] - origin, corners[tet[3]] - origin)));
      for (int k = 0; k < 3; ++k) {
        // A tet with both ends of the other diagonal of a quad contradicts the pattern.
        const uint32_t from = uint32_t(k), to = uint32_t((k + 1) % 3);
        const bool rises = pattern >> k & 1;
        const uint32_t low = rises ? to : from, high = 3 + (rises ? from : to);
        int ends = 0;
        for (int i = 0; i < 4; ++i) ends += tet[i] == low || tet[i] == high;
        EXPECT_LT(ends, 2) << "pattern " << int(pattern);
      }
    }
    EXPECT_EQ(volumes, (std::vector<double>{0.5, 0.125, 0.25})) << "pattern " << int(pattern);
  }
}

TEST(PrismDiagonals, OfBothMethodsAgreeBetweenNeighborsAroundEveryVertex) {
  Random random(2);
  size_t stars = 0;
  for (uint64_t seed = 0; seed < 5; ++seed) {
    const TetMesh mesh = JitteredBox(7, seed);
    std::vector<uint32_t> rank(mesh.positions.size());
    std::iota(rank.begin(), rank.end(), 0u);
    for (size_t i = rank.size() - 1; i > 0; --i) {
      std::swap(rank[i], rank[random.Below(uint32_t(i + 1))]);
    }
    for (std::vector<glm::uvec3>& bottoms : BottomsOfStars(mesh)) {
      ++stars;
      ExpectCompatible(bottoms, DiagonalsByRank(bottoms, rank));
      // In a random order the search meets prisms that its neighbours left no pattern.
      for (size_t i = bottoms.size() - 1; i > 0; --i) {
        std::swap(bottoms[i], bottoms[random.Below(uint32_t(i + 1))]);
      }
      const auto flips = DiagonalsByFlips(bottoms);
      ASSERT_TRUE(flips);
      ExpectCompatible(bottoms, *flips);
    }
  }
  EXPECT_GT(stars, 1500u);
}

// The surface of a mesh is a link of thousands of prisms.
TEST(PrismDiagonals, OfFlipsAreFoundOnALargeLink) {
  std::vector<glm::vec3> points;
  Random random(9);
  for (int i = 0; i < 4000; ++i) {
    const double z = 2 * random.Uniform() - 1, turn = 6.283 * random.Uniform();
    const double r = std::sqrt(1 - z * z);
    points.push_back(glm::vec3(r * std::cos(turn), r * std::sin(turn), z));
  }
  points.push_back(glm::vec3(0.0f));
  const TetMesh mesh = BuildDelaunay(points).mesh;
  std::vector<glm::uvec3> bottoms;
  for (const auto& of_vertex : BottomsOfStars(mesh)) {
    if (of_vertex.size() > bottoms.size()) bottoms = of_vertex;
  }
  EXPECT_GT(bottoms.size(), 2000u);
  const auto flips = DiagonalsByFlips(bottoms);
  ASSERT_TRUE(flips);
  ExpectCompatible(bottoms, *flips);
}

TEST(PrismDiagonals, StartAtTheVertexOfSmallerRank) {
  const std::vector<glm::uvec3> bottoms = {{0, 1, 2}};
  EXPECT_EQ(DiagonalsByRank(bottoms, std::vector<uint32_t>{0, 1, 2})[0], 0b011);
  EXPECT_EQ(DiagonalsByRank(bottoms, std::vector<uint32_t>{2, 1, 0})[0], 0b100);
}

}  // namespace
}  // namespace tetrec
