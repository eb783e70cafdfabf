#include "mesh/mesh_edges.h"

#include "mesh/delaunay.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <utility>

namespace tetrec {
namespace {

TEST(MeshEdges, AreNumberedOnceAndNamedByTheirTets) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < 27; ++i) points.emplace_back(i % 3, i / 3 % 3, i / 9);
  const TetMesh mesh = BuildDelaunay(points).mesh;
  const MeshEdges edges = EdgesOf(mesh);
  std::set<std::pair<uint32_t, uint32_t>> distinct;
  for (const glm::uvec2& ends : edges.ends) {
    EXPECT_LT(ends.x, ends.y);
    distinct.emplace(ends.x, ends.y);
  }
  EXPECT_EQ(distinct.size(), edges.ends.size());
  ASSERT_EQ(edges.of_tets.size(), 6 * mesh.tets.size());
  std::set<uint32_t> named;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (size_t e = 0; e < 6; ++e) {
      const glm::uvec2& ends = edges.ends.at(edges.of_tets[6 * t + e]);
      const auto wanted = std::minmax(mesh.tets[t][kTetEdges[e][0]], mesh.tets[t][kTetEdges[e][1]]);
      EXPECT_EQ(std::pair(ends.x, ends.y), std::pair(wanted.first, wanted.second));
      named.insert(edges.of_tets[6 * t + e]);
    }
  }
  EXPECT_EQ(named.size(), edges.ends.size());
}

TEST(MeshEdges, KnowTheLongestOfATet) {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 2, 0}, {0, 0, 3}};
  EXPECT_EQ(LongestEdge(mesh, {0, 1, 2, 3}), 5);
  EXPECT_EQ(LongestEdge(mesh, {3, 2, 0, 1}), 0);
}

}  // namespace
}  // namespace tetrec
