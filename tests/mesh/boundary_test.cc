// Boundaries of meshes: the check for convexity and the tree of boxes over their faces.
#include "mesh/boundary.h"

#include "core/error.h"
#include "expect_error.h"
#include "mesh/delaunay.h"
#include "mesh/locate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>
#include <set>

namespace tetrec {
namespace {

TetMesh MeshOfRandomPoints(int points, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(-1, 1);
  std::vector<glm::vec3> all;
  for (int i = 0; i < points; ++i) all.emplace_back(unit(random), unit(random), unit(random));
  return BuildDelaunay(all).mesh;
}

// The part of the mesh that consists of the tets with keep(tet).
template <class Keep>
TetMesh Kept(TetMesh mesh, const Keep& keep) {
  std::vector<glm::uvec4> tets;
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    if (keep(t)) tets.push_back(mesh.tets[t]);
  }
  mesh.tets = std::move(tets);
  mesh.neighbors = ComputeNeighbors(mesh.tets, mesh.positions.size());
  return mesh;
}

std::string WhyNotConvex(const TetMesh& mesh) {
  return tetrec::WhyNotConvex(mesh, BoundaryFaces(mesh));
}

TEST(Boundary, OfADelaunayMeshIsConvex) {
  for (int points : {4, 5, 20, 500}) EXPECT_EQ(WhyNotConvex(MeshOfRandomPoints(points, 3)), "");
}

TEST(Boundary, AnyTetTakenOutOfTheMiddleMakesItNotConvex) {
  const TetMesh mesh = MeshOfRandomPoints(60, 4);
  for (uint32_t hole = 0; hole < mesh.tets.size(); ++hole) {
    const glm::uvec4& n = mesh.neighbors[hole];
    if (n.x == kNoTet || n.y == kNoTet || n.z == kNoTet || n.w == kNoTet) continue;
    EXPECT_NE(WhyNotConvex(Kept(mesh, [&](uint32_t t) { return t != hole; })), "") << hole;
  }
}

TEST(Boundary, TwoConvexPartsAreNotConvex) {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1},
                    {0, 0, 5}, {1, 0, 5}, {0, 1, 5}, {0, 0, 6}};
  mesh.tets = {{0, 1, 2, 3}, {4, 5, 6, 7}};
  mesh.neighbors = ComputeNeighbors(mesh.tets, 8);
  EXPECT_NO_THROW(CheckTetMesh(mesh));
  ExpectError<DataError>([&] { CheckConvexDomain(mesh); }, {"not convex"});
}

void ExpectHolds(const BoxTree& tree, uint32_t node, const glm::vec3& p) {
  ASSERT_TRUE(glm::all(glm::lessThan(tree.nodes[node].min, p)));
  ASSERT_TRUE(glm::all(glm::lessThan(p, tree.nodes[node].max)));
}

TEST(BoxTree, EveryFaceIsInOneLeafAndInsideAllBoxesAboveIt) {
  for (int points : {4, 7, 300}) {
    const TetMesh full = MeshOfRandomPoints(points, 5);
    const TetMesh mesh = Kept(full, [](uint32_t t) { return t % 3 != 1; });
    std::vector<BoundaryFace> faces = BoundaryFaces(mesh);
    const size_t count = faces.size();
    const BoxTree tree = BuildBoxTree(mesh, faces);
    ASSERT_EQ(faces.size(), count);
    ASSERT_TRUE(std::has_single_bit(tree.leaves));
    ASSERT_EQ(tree.nodes.size(), 2 * tree.leaves);
    std::multiset<uint32_t> found;
    for (uint32_t leaf = tree.leaves; leaf < 2 * tree.leaves; ++leaf) {
      const std::set<uint32_t> held = {tree.nodes[leaf].first, tree.nodes[leaf].second};
      found.insert(held.begin(), held.end());
      for (uint32_t face : held) {
        for (int corner : kFaceVertices[faces[face].face]) {
          const glm::vec3& p = mesh.positions[mesh.tets[faces[face].tet][corner]];
          for (uint32_t node = leaf; node > 0; node /= 2) ExpectHolds(tree, node, p);
        }
      }
    }
    EXPECT_EQ(found.size(), count);
    EXPECT_EQ(std::set<uint32_t>(found.begin(), found.end()).size(), count);
  }
}

bool Holds(const TetMesh& mesh, uint32_t t, const glm::dvec3& p) {
  for (int i = 0; i < 4; ++i) {
    const auto& corner = kFaceVertices[i];
    const glm::dvec3 a(mesh.positions[mesh.tets[t][corner[0]]]),
        b(mesh.positions[mesh.tets[t][corner[1]]]), c(mesh.positions[mesh.tets[t][corner[2]]]);
    if (glm::dot(glm::cross(b - a, c - a), p - a) > 0) return false;
  }
  return true;
}

TEST(FindTet, FindsTheTetInAMeshWithHolesFromAnyStart) {
  const TetMesh mesh = Kept(MeshOfRandomPoints(200, 6), [](uint32_t t) { return t % 3 != 1; });
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1.2, 1.2);
  int inside = 0;
  for (int i = 0; i < 300; ++i) {
    const glm::dvec3 p(unit(random), unit(random), unit(random));
    uint32_t truth = kNoTet;
    for (uint32_t t = 0; t < mesh.tets.size() && truth == kNoTet; ++t) {
      if (Holds(mesh, t, p)) truth = t;
    }
    inside += truth != kNoTet;
    EXPECT_EQ(FindTet(mesh, p, uint32_t(random() % mesh.tets.size())), truth);
  }
  EXPECT_GT(inside, 50);
}

// Walks along it are longer than any that a mesh of this size should need.
TEST(FindTet, FindsTetsFarAwayInALongMesh) {
  std::mt19937 random(17);
  std::uniform_real_distribution<float> unit;
  std::vector<glm::vec3> points;
  for (int i = 0; i < 3000; ++i)
    points.emplace_back(3000 * unit(random), unit(random), unit(random));
  const TetMesh mesh = BuildDelaunay(points).mesh;
  const auto centroid = [&](uint32_t t) {
    glm::dvec3 sum(0.0);
    for (int i = 0; i < 4; ++i) sum += glm::dvec3(mesh.positions[mesh.tets[t][i]]);
    return 0.25 * sum;
  };
  uint32_t first = 0, last = 0;
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    if (centroid(t).x < centroid(first).x) first = t;
    if (centroid(t).x > centroid(last).x) last = t;
  }
  EXPECT_EQ(FindTet(mesh, centroid(last), first, true), last);
  EXPECT_EQ(FindTet(mesh, centroid(first), last, true), first);
}

}  // namespace
}  // namespace tetrec
