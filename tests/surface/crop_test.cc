#include "surface/crop.h"

#include "mesh/mesh_facts.h"
#include "surface/clean.h"
#include "surface/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

constexpr double kPi = 3.14159265358979;

// The way into a frame of twice the size, turned by a quarter about z.
const Similarity3 kTwiceAndTurned{
    .scale = 2, .rotation = {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}, .translation = {1, 2, 3}};

TEST(CutByBox, CutsTrianglesFlushWithTheBox) {
  const TriangleMesh ball = Sphere(1, {0, 0, 0});
  const Bounds3 all = BoundsOf(Transformed(ball, kTwiceAndTurned).positions);
  Bounds3 upper = all.Scaled(2);
  upper.min.z = 3.4;  // 0.2 above the centre of the ball
  const CutSurface cut = CutByBox(ball, upper, kTwiceAndTurned);
  EXPECT_NEAR(BoundsOf(cut.inside.positions).min.z, 0.2, 1e-6);
  EXPECT_NEAR(BoundsOf(cut.outside.positions).max.z, 0.2, 1e-6);
  EXPECT_EQ(BoundsOf(cut.inside.positions).max.z, BoundsOf(ball.positions).max.z);
  EXPECT_EQ(cut.inside.colors_srgb.size(), cut.inside.positions.size());

  const MeshFacts whole = MeasureMesh(ball), inside = MeasureMesh(cut.inside),
                  outside = MeasureMesh(cut.outside);
  EXPECT_NEAR(inside.area + outside.area, whole.area, 1e-5);
  EXPECT_NEAR(inside.area, 2 * kPi * 0.8, 0.1);  // a cap of height 0.8
  for (const MeshFacts& part : {inside, outside}) {
    EXPECT_EQ(part.euler_characteristic, 1);  // a disc
    EXPECT_EQ(part.non_manifold_edges + part.non_manifold_vertices, 0u);
  }
  EXPECT_EQ(inside.boundary_edges, outside.boundary_edges);
}

TEST(CutByBox, CutsOffAllSixSides) {
  const TriangleMesh ball = Sphere(1, {0, 0, 0});
  const Bounds3 box{glm::dvec3(-0.7, -0.75, -0.8), glm::dvec3(0.8, 0.75, 0.7)};
  const CutSurface cut = CutByBox(ball, box);
  const Bounds3 bounds = BoundsOf(cut.inside.positions);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(bounds.min[axis], box.min[axis], 1e-6);
    EXPECT_NEAR(bounds.max[axis], box.max[axis], 1e-6);
  }
  EXPECT_NEAR(MeasureMesh(cut.inside).area + MeasureMesh(cut.outside).area, MeasureMesh(ball).area,
              1e-5);
}

TEST(CutByBox, LeavesAloneWhatTheBoxContains) {
  const TriangleMesh ball = Sphere(1, {0, 0, 0});
  const CutSurface all = CutByBox(ball, {glm::dvec3(-3), glm::dvec3(3)});
  EXPECT_EQ(all.inside.positions, ball.positions);
  EXPECT_EQ(all.inside.colors_srgb, ball.colors_srgb);
  EXPECT_EQ(all.inside.triangles, ball.triangles);
  EXPECT_TRUE(all.outside.triangles.empty() && all.outside.positions.empty());
  const CutSurface none = CutByBox(ball, {glm::dvec3(2), glm::dvec3(3)});
  EXPECT_TRUE(none.inside.triangles.empty() && none.inside.positions.empty());
  EXPECT_NEAR(MeasureMesh(none.outside).area, MeasureMesh(ball).area, 1e-5);
}

TEST(CutByBox, MovesVerticesOntoAFaceThatTheyAlmostTouch) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 1e-7f}, {0, 1, -1}, {0, 0, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {0, 2, 4}};
  const CutSurface cut = CutByBox(mesh, {glm::dvec3(-2, -2, 0), glm::dvec3(2)});
  // The first lies in the face and counts as inside.
  ASSERT_EQ(cut.inside.triangles.size(), 2u);
  EXPECT_EQ(cut.inside.positions[2].z, 0);
  EXPECT_EQ(cut.outside.triangles.size(), 1u);
  // A cut through a corner makes two triangles of one.
  mesh.triangles = {{0, 3, 4}};
  const CutSurface halves = CutByBox(mesh, {glm::dvec3(-2, -2, 0), glm::dvec3(2)});
  EXPECT_EQ(halves.inside.triangles.size(), 1u);
  EXPECT_EQ(halves.outside.triangles.size(), 1u);
}

}  // namespace
}  // namespace tetrec
