#include "mesh/mesh_facts.h"

#include "mesh/triangle_shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

TEST(MeshFacts, AClosedSphereIsWatertightAndHasItsAreaAndVolume) {
  const MeshFacts facts = MeasureMesh(TestSphere(100, 1));
  EXPECT_TRUE(facts.watertight);
  EXPECT_EQ(facts.components, 1u);
  // The polyhedron is inside the sphere: both values fall short by about (pi / 100)^2 = 1e-3.
  EXPECT_NEAR(facts.area, 4 * M_PI, 4 * M_PI * 1e-3);
  EXPECT_NEAR(facts.volume, 4 * M_PI / 3, 4 * M_PI / 3 * 2e-3);
}

TEST(MeshFacts, HolesLoosePiecesAndFlippedFacesShow) {
  TriangleMesh open = TestSphere(8, 1);
  open.triangles.pop_back();
  EXPECT_EQ(MeasureMesh(open).boundary_edges, 3u);
  EXPECT_FALSE(MeasureMesh(open).watertight);

  TriangleMesh flipped = TestSphere(8, 1);
  std::swap(flipped.triangles[0].x, flipped.triangles[0].y);
  EXPECT_EQ(MeasureMesh(flipped).non_manifold_edges, 3u);
  EXPECT_FALSE(MeasureMesh(flipped).watertight);

  TriangleMesh two = Plane(1, 1, 0);
  two.triangles.pop_back();
  two.positions.insert(two.positions.end(), {{9, 9, 9}, {8, 9, 9}, {9, 8, 9}, {7, 7, 7}});
  two.triangles.emplace_back(4, 5, 6);
  EXPECT_EQ(MeasureMesh(two).components, 2u);  // the unused vertex 7 is not a piece
  EXPECT_FALSE(MeasureMesh({}).watertight);
}

TEST(MeshFacts, FindsAVertexThatJoinsTwoPieces) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  const MeshFacts facts = MeasureMesh(mesh);
  EXPECT_EQ(facts.non_manifold_vertices, 1u);
  EXPECT_EQ(facts.boundary_edges, 6u);
}

}  // namespace
}  // namespace tetrec
