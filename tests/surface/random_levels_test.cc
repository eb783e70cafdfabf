// Level sets of random functions on random meshes, judged by CGAL and by counting.
#include "mesh/boundary.h"
#include "mesh/delaunay.h"
#include "mesh/mesh_facts.h"
#include "surface/marching_tetrahedra.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace tetrec {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalMesh = CGAL::Surface_mesh<Kernel::Point_3>;

// Points of very different density, some of them nearly on a plane or a line, inside a box whose
// corners are far away: the Delaunay mesh has tets of all sizes and many slivers.
TetMesh RandomMesh(std::mt19937& random, int points) {
  std::uniform_real_distribution<float> uniform(-1, 1);
  const float scale = std::exp2(-5 * std::abs(uniform(random)));
  const float flatness = std::exp2(-12 * std::abs(uniform(random)));
  const glm::vec3 center(uniform(random), uniform(random), uniform(random));
  std::vector<glm::vec3> positions;
  for (int corner = 0; corner < 8; ++corner) {
    positions.push_back({corner & 1 ? 3 : -3, corner & 2 ? 3 : -3, corner & 4 ? 3 : -3});
  }
  for (int i = 0; i < points; ++i) {
    glm::vec3 p(uniform(random), uniform(random), uniform(random));
    if (i % 2 == 0) p = center + scale * p * glm::vec3(1, 1, i % 4 == 0 ? flatness : 1);
    positions.push_back(p);
  }
  return BuildDelaunay(positions).mesh;
}

// Levels in any order of magnitude, half of them of few different values, so that many are equal to
// the isovalue 0. The hull is outside.
std::vector<float> RandomLevels(std::mt19937& random, const TetMesh& mesh) {
  std::normal_distribution<float> normal;
  const bool few = random() % 2 == 0;
  const float spread = 8 * std::abs(normal(random));
  std::vector<float> levels;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    levels.push_back(few ? float(int(random() % 5) - 2)
                         : std::exp2(spread * normal(random)) * normal(random));
  }
  const std::vector<uint8_t> on_hull = BoundaryVertices(mesh);
  for (size_t v = 0; v < levels.size(); ++v) {
    if (on_hull[v]) levels[v] = -1;
  }
  return levels;
}

CgalMesh ToCgal(const LevelSet& set) {
  CgalMesh mesh;
  std::vector<CgalMesh::Vertex_index> ids;
  for (const glm::vec3& p : set.positions) ids.push_back(mesh.add_vertex({p.x, p.y, p.z}));
  for (const glm::uvec3& t : set.triangles) mesh.add_face(ids[t.x], ids[t.y], ids[t.z]);
  return mesh;
}

TEST(RandomLevels, EveryLevelSetIsClosedOrientedManifoldAndFreeOfSelfIntersections) {
  size_t surfaces = 0, triangles = 0;
  for (unsigned seed = 1; seed <= 1000; ++seed) {
    std::mt19937 random(seed);
    const TetMesh mesh = RandomMesh(random, 10 + int(random() % 50));
    const LevelSet set = MarchTetrahedra(mesh, RandomLevels(random, mesh), 0);
    if (set.triangles.empty()) continue;
    ++surfaces;
    const MeshFacts facts = MeasureMesh({set.positions, {}, set.triangles});
    ASSERT_TRUE(facts.IsClosedManifold()) << "seed " << seed;
    // Of a closed, oriented surface: 2 per piece less 2 per handle.
    ASSERT_EQ(facts.euler_characteristic % 2, 0) << "seed " << seed;
    ASSERT_LE(facts.euler_characteristic, 2 * int64_t(facts.components)) << "seed " << seed;
    const CgalMesh cgal = ToCgal(set);
    ASSERT_EQ(cgal.number_of_faces(), set.triangles.size()) << "seed " << seed;
    ASSERT_FALSE(CGAL::Polygon_mesh_processing::does_self_intersect(cgal)) << "seed " << seed;
    triangles += set.triangles.size();
  }
  EXPECT_GT(surfaces, 900u);
  EXPECT_GT(triangles, 50u * 900);
}

}  // namespace
}  // namespace tetrec
