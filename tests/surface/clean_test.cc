#include "surface/clean.h"

#include "mesh/mesh_facts.h"
#include "surface/shapes.h"
#include "surface/simplify.h"

#include <gtest/gtest.h>

#include <random>

namespace tetrec {
namespace {

TEST(KeepLargePieces, DropsSmallPiecesAndCavities) {
  const TriangleMesh large = Sphere(1, {0, 0, 0});
  TriangleMesh all = Sphere(0.02, {3, 0, 0});
  for (const TriangleMesh& part : {large, Sphere(0.5, {0, 0, 0}, true), Sphere(0.3, {0, 4, 0})}) {
    all = Joined(all, part);
  }
  const CleanResult result = KeepLargePieces(all, {});
  EXPECT_EQ(result.components, 4u);
  EXPECT_EQ(result.dropped_small, 1u);
  EXPECT_EQ(result.dropped_cavities, 1u);
  EXPECT_EQ(result.dropped_triangles, 2 * large.triangles.size());
  EXPECT_EQ(result.mesh.positions.size(), 2 * large.positions.size());
  EXPECT_EQ(result.mesh.colors_srgb.size(), result.mesh.positions.size());
  EXPECT_EQ(result.mesh.colors_srgb[300], large.colors_srgb[300]);
  EXPECT_TRUE(MeasureMesh(result.mesh).IsClosedManifold());
  // Compared with a part of the whole, the ball of 0.02 is not small.
  EXPECT_EQ(KeepLargePieces(all, {}, &result.mesh).dropped_small, 1u);
  const TriangleMesh small = Sphere(0.1, {3, 0, 0});
  EXPECT_EQ(KeepLargePieces(all, {}, &small).dropped_small, 0u);
  CleanOptions keep;
  keep.keep_cavities = true;
  keep.min_component_share = 0;
  EXPECT_EQ(KeepLargePieces(all, keep).mesh.triangles, all.triangles);
}

TEST(KeepLargePieces, KeepsARoomAroundACamera) {
  const TriangleMesh room = Sphere(1, {0, 0, 0}, true);
  CleanOptions options;
  options.cameras = {{0, 0, 3}};
  EXPECT_EQ(KeepLargePieces(room, options).dropped_cavities, 1u);
  options.cameras = {{0.9, 0.9, 0.9}};  // beside the ball, in its box
  EXPECT_EQ(KeepLargePieces(room, options).dropped_cavities, 1u);
  options.cameras.emplace_back(0.2, 0, 0.1);
  EXPECT_EQ(KeepLargePieces(room, options).mesh.triangles, room.triangles);
}

TEST(KeepLargePieces, ARoomAroundACameraIsTheMainPartInACropThatContainsIt) {
  const TriangleMesh room = Sphere(1, {0, 0, 0}, true);
  const TriangleMesh all = Joined(room, Sphere(0.02, {3, 0, 0}));
  CleanOptions options;
  options.cameras = {{0.2, 0, 0.1}};
  EXPECT_EQ(KeepLargePieces(all, options, &room).dropped_small, 1u);
  EXPECT_EQ(KeepLargePieces(all, options, &room).mesh.triangles, room.triangles);
}

TEST(SeparateFans, MakesAManifoldOfTrianglesThatMeetInAPoint) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  const TriangleMesh separate = SeparateFans(mesh);
  EXPECT_EQ(separate.positions.size(), 6u);
  EXPECT_EQ(MeasureMesh(separate).non_manifold_vertices, 0u);
  EXPECT_EQ(separate.positions[separate.triangles[1].x], mesh.positions[0]);
}

TEST(SeparateFans, LetsARaggedCropBeDecimated) {
  const TetMesh tets = JitteredBox(8);
  std::mt19937 random(3);
  const LevelSet set = MarchTetrahedra(
      tets, Sampled(tets, [&](const glm::dvec3&) { return double(random() % 2); }), 0.5f);
  const TriangleMesh crop = AsTriangles(CropTo(set, {glm::dvec3(-0.7), glm::dvec3(0.9)}));
  ASSERT_GT(MeasureMesh(crop).non_manifold_vertices, 0u);
  const TriangleMesh separate = SeparateFans(crop);
  EXPECT_EQ(MeasureMesh(separate).non_manifold_vertices, 0u);
  EXPECT_LT(Decimate(separate, separate.triangles.size() / 2).triangles.size(),
            separate.triangles.size());
}

TEST(SeparateFans, LeavesManifoldsAlone) {
  const TriangleMesh sphere = Sphere(1, {0, 0, 0});
  EXPECT_EQ(SeparateFans(sphere).triangles, sphere.triangles);
}

TEST(Transformed, ScalesAreasBySquareOfTheScale) {
  const TriangleMesh sphere = Sphere(1, {0, 0, 0});
  // A quarter turn about z.
  const Similarity3 transform{3.0, glm::dmat3({0, 1, 0}, {-1, 0, 0}, {0, 0, 1}), {10, 20, 30}};
  const MeshFacts before = MeasureMesh(sphere), after = MeasureMesh(Transformed(sphere, transform));
  EXPECT_NEAR(after.area, 9 * before.area, 1e-4 * after.area);  // float vertices
  EXPECT_NEAR(after.volume, 27 * before.volume, 1e-4 * after.volume);
}

}  // namespace
}  // namespace tetrec
