#include "surface/fill_holes.h"

#include "mesh/mesh_facts.h"
#include "surface/shapes.h"

#include <gtest/gtest.h>

#include <numbers>

namespace tetrec {
namespace {

// A sphere without the triangles that touch the balls of `radius` around the given points.
TriangleMesh WithHoles(const TriangleMesh& sphere, const std::vector<glm::vec3>& at, float radius) {
  TriangleMesh mesh = sphere;
  std::erase_if(mesh.triangles, [&](const glm::uvec3& t) {
    for (int k = 0; k < 3; ++k) {
      for (const glm::vec3& p : at) {
        if (glm::distance(mesh.positions[t[k]], p) < radius) return true;
      }
    }
    return false;
  });
  return mesh;
}

TEST(FillSmallHoles, ClosesThoseBelowThePerimeter) {
  const TriangleMesh sphere = Sphere(1, {0, 0, 0});
  TriangleMesh holed = WithHoles(sphere, {{0, 0, 1}, {1, 0, 0}}, 0.15f);
  holed = WithHoles(holed, {{0, 0, -1}}, 0.6f);
  ASSERT_FALSE(MeasureMesh(holed).watertight);
  // The border is ragged: the small loops are about twice as long as circles of radius 0.2.
  const FilledHoles filled = FillSmallHoles(holed, 2.5);
  EXPECT_EQ(filled.holes, 2u);
  EXPECT_EQ(filled.mesh.triangles.size(), holed.triangles.size() + filled.triangles);
  EXPECT_EQ(filled.mesh.positions, holed.positions);
  const MeshFacts facts = MeasureMesh(filled.mesh);
  EXPECT_GT(facts.boundary_edges, 0u);
  EXPECT_EQ(facts.non_manifold_edges, 0u);

  const MeshFacts closed = MeasureMesh(FillSmallHoles(holed, 100).mesh);
  EXPECT_TRUE(closed.watertight);
  // Flat caps instead of round ones: that of the large hole cuts off h = 1 - cos(0.6) or more.
  EXPECT_GT(closed.volume, 0.9 * 4 * std::numbers::pi / 3);
  EXPECT_EQ(FillSmallHoles(sphere, 100).holes, 0u);
}

TEST(FillSmallHoles, LeavesPatchesAlone) {
  TriangleMesh patch;
  patch.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.1f}, {0, 1, 0}};
  patch.triangles = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(FillSmallHoles(patch, 100).holes, 0u);
}

}  // namespace
}  // namespace tetrec
