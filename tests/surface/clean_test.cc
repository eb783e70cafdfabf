#include "surface/clean.h"

#include "mesh/mesh_facts.h"
#include "surface/shapes.h"
#include "surface/simplify.h"

#include <gtest/gtest.h>

#include <random>

namespace tetrec {
namespace {

TriangleMesh Joined(std::initializer_list<TriangleMesh> parts) {
  TriangleMesh all;
  for (const TriangleMesh& part : parts) {
    const uint32_t offset = uint32_t(all.positions.size());
    all.positions.insert(all.positions.end(), part.positions.begin(), part.positions.end());
    all.colors_srgb.insert(all.colors_srgb.end(), part.colors_srgb.begin(), part.colors_srgb.end());
    for (const glm::uvec3& t : part.triangles) all.triangles.push_back(t + offset);
  }
  return all;
}

TEST(KeepLargePieces, DropsSmallPiecesAndCavities) {
  const TriangleMesh large = Sphere(1, {0, 0, 0});
  const TriangleMesh all = Joined(
      {Sphere(0.02, {3, 0, 0}), large, Sphere(0.5, {0, 0, 0}, true), Sphere(0.3, {0, 4, 0})});
  const CleanResult result = KeepLargePieces(all, {});
  EXPECT_EQ(result.components, 4u);
  EXPECT_EQ(result.dropped_small, 1u);
  EXPECT_EQ(result.dropped_cavities, 1u);
  EXPECT_EQ(result.dropped_triangles, 2 * large.triangles.size());
  EXPECT_EQ(result.mesh.positions.size(), 2 * large.positions.size());
  EXPECT_EQ(result.mesh.colors_srgb.size(), result.mesh.positions.size());
  EXPECT_EQ(result.mesh.colors_srgb[300], large.colors_srgb[300]);
  EXPECT_TRUE(MeasureMesh(result.mesh).IsClosedManifold());
  CleanOptions keep;
  keep.keep_cavities = true;
  keep.min_component_share = 0;
  EXPECT_EQ(KeepLargePieces(all, keep).mesh.triangles, all.triangles);
}

TEST(CropTo, LeavesOutTrianglesWithAVertexOutside) {
  const TriangleMesh ball = Sphere(1, {0, 0, 0});
  const Similarity3 twice{.scale = 2};
  const TriangleMesh upper = CropTo(ball, {glm::dvec3(-3, -3, 0.2), glm::dvec3(3)}, twice);
  size_t inside = 0;
  for (const glm::vec3& p : ball.positions) inside += 2 * p.z >= 0.2f;
  EXPECT_EQ(upper.positions.size(), inside);
  EXPECT_EQ(upper.colors_srgb.size(), inside);
  EXPECT_GE(2 * BoundsOf(upper.positions).min.z, 0.2);
  EXPECT_GT(upper.triangles.size(), 50u);
  EXPECT_LT(upper.triangles.size(), ball.triangles.size() / 2);
  EXPECT_EQ(CropTo(ball, {glm::dvec3(-3), glm::dvec3(3)}).triangles, ball.triangles);
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
