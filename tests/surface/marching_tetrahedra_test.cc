#include "surface/marching_tetrahedra.h"

#include "core/error.h"
#include "mesh/mesh_facts.h"
#include "surface/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <random>

namespace tetrec {
namespace {

TEST(MarchTetrahedra, MakesAClosedSphereAndTorus) {
  const TetMesh mesh = JitteredBox(14);
  const LevelSet sphere = MarchTetrahedra(mesh, Sampled(mesh, Ball), 0);
  MeshFacts facts = MeasureMesh(AsTriangles(sphere));
  EXPECT_TRUE(facts.IsClosedManifold());
  EXPECT_EQ(facts.euler_characteristic, 2);
  const LevelSet torus = MarchTetrahedra(mesh, Sampled(mesh, Torus), 0);
  facts = MeasureMesh(AsTriangles(torus));
  EXPECT_TRUE(facts.IsClosedManifold());
  EXPECT_EQ(facts.euler_characteristic, 0);
}

// A piecewise linear level set is of second order: on regular grids halving the edges leaves a
// quarter of the error. The grids are jittered, so the bound is a third.
TEST(MarchTetrahedra, ConvergesToTheSphereUnderRefinement) {
  double area_error = 1e9, volume_error = 1e9;
  for (const int cells : {6, 12, 24}) {
    const TetMesh mesh = JitteredBox(cells);
    const MeshFacts facts = MeasureMesh(AsTriangles(MarchTetrahedra(mesh, Sampled(mesh, Ball), 0)));
    const double area = std::abs(facts.area / (4 * std::numbers::pi) - 1);
    const double volume = std::abs(facts.volume / (4 * std::numbers::pi / 3) - 1);
    EXPECT_LT(area, area_error / 3) << cells;
    EXPECT_LT(volume, volume_error / 3) << cells;
    area_error = area;
    volume_error = volume;
  }
  EXPECT_GT(area_error, 0);
}

TEST(MarchTetrahedra, FacesOutward) {
  const TetMesh mesh = JitteredBox(8);
  const LevelSet set = MarchTetrahedra(mesh, Sampled(mesh, Ball), 0);
  const MeshFacts facts = MeasureMesh(AsTriangles(set));
  EXPECT_GT(facts.volume, 3.5);
  const auto inverted = Sampled(mesh, [](const glm::dvec3& p) { return -Ball(p); });
  EXPECT_LT(MeasureMesh(AsTriangles(MarchTetrahedra(mesh, inverted, 0))).volume, -3.5);
}

// All levels are whole numbers, so many lie exactly on the isovalue.
TEST(MarchTetrahedra, StaysAManifoldWhereVerticesLieOnTheLevel) {
  const TetMesh mesh = JitteredBox(12);
  const auto steps = Sampled(mesh, [](const glm::dvec3& p) { return std::round(4 * Ball(p)); });
  ASSERT_GT(std::count(steps.begin(), steps.end(), 1.0f), 20);
  const LevelSet set = MarchTetrahedra(mesh, steps, 1);
  EXPECT_TRUE(MeasureMesh(AsTriangles(set)).IsClosedManifold());
  for (const glm::uvec3& t : set.triangles) {
    const glm::dvec3 a(set.positions[t.x]), b(set.positions[t.y]), c(set.positions[t.z]);
    ASSERT_GT(glm::length(glm::cross(b - a, c - a)), 0) << "a triangle vanished";
  }
}

// Random signs produce every case of every tet, and pieces that touch the boundary.
TEST(MarchTetrahedra, IsAManifoldForAnyLevels) {
  const TetMesh mesh = JitteredBox(6);
  for (unsigned seed = 1; seed <= 10; ++seed) {
    std::mt19937 random(seed);
    const auto noise = Sampled(mesh, [&](const glm::dvec3&) { return double(random() % 5); });
    const MeshFacts facts = MeasureMesh(AsTriangles(MarchTetrahedra(mesh, noise, 2)));
    EXPECT_EQ(facts.non_manifold_edges, 0u) << "seed " << seed;
    EXPECT_EQ(facts.non_manifold_vertices, 0u) << "seed " << seed;
  }
}

TEST(MarchTetrahedra, PutsVerticesWhereTheLinearFunctionHasTheIsovalue) {
  const TetMesh mesh = JitteredBox(6);
  const auto plane = Sampled(mesh, [](const glm::dvec3& p) { return 2 * p.x - p.y + 0.5 * p.z; });
  const LevelSet set = MarchTetrahedra(mesh, plane, 0.25f);
  ASSERT_FALSE(set.positions.empty());
  int clamped = 0;
  for (size_t v = 0; v < set.positions.size(); ++v) {
    const float t = set.cuts[v].t;
    clamped += t < 0.0011f || t > 0.9989f;
    const glm::dvec3 p(set.positions[v]);
    // A clamped cut is off by at most a thousandth of an edge, others by float rounding.
    EXPECT_NEAR(2 * p.x - p.y + 0.5 * p.z, 0.25, clamped > 0 ? 3e-3 : 1e-6);
  }
}

TEST(MarchTetrahedra, NamesTheTetOfEachTriangle) {
  const TetMesh mesh = JitteredBox(5);
  const LevelSet set = MarchTetrahedra(mesh, Sampled(mesh, Ball), 0);
  for (size_t f = 0; f < set.triangles.size(); ++f) {
    const glm::uvec4& tet = mesh.tets[set.tets[f]];
    for (int k = 0; k < 3; ++k) {
      const EdgeCut& cut = set.cuts[set.triangles[f][k]];
      EXPECT_TRUE(glm::any(glm::equal(tet, glm::uvec4(cut.inside))));
      EXPECT_TRUE(glm::any(glm::equal(tet, glm::uvec4(cut.outside))));
    }
  }
}

TEST(MarchTetrahedra, RefusesBadLevels) {
  const TetMesh mesh = JitteredBox(3);
  std::vector<float> level = Sampled(mesh, Ball);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(MarchTetrahedra(mesh, level, nan), DataError);
  EXPECT_THROW(MarchTetrahedra(mesh, std::span(level).first(3), 0), DataError);
  level[5] = nan;
  EXPECT_THROW(MarchTetrahedra(mesh, level, 0), DataError);
}

TEST(CropTo, KeepsTheInside) {
  const TetMesh mesh = JitteredBox(10);
  const LevelSet set = MarchTetrahedra(mesh, Sampled(mesh, Ball), 0);
  const LevelSet half = CropTo(set, {{-2, -2, 0}, {2, 2, 2}});
  const MeshFacts facts = MeasureMesh(AsTriangles(half));
  // The ragged rim is short of the equator by less than the width of a cell, 0.3.
  EXPECT_LT(facts.area, 2 * std::numbers::pi);
  EXPECT_GT(facts.area, 2 * std::numbers::pi * (1 - 0.3));
  EXPECT_GT(facts.boundary_edges, 0u);
  for (const glm::vec3& p : half.positions) EXPECT_GE(p.z, 0);
  EXPECT_TRUE(CropTo(set, {glm::dvec3(5), glm::dvec3(6)}).triangles.empty());
}

TEST(ColoredSurface, PrefersTheDenseEnd) {
  RadianceField field;
  field.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  field.mesh.tets = {{0, 1, 2, 3}};
  field.mesh.neighbors = {glm::uvec4(kNoTet)};
  field.density = {10, 0, 0, 0};
  field.color_srgb = {{1, 0.5f, 2}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
  const LevelSet set = MarchTetrahedra(field.mesh, field.density, 5);
  const TriangleMesh mesh = ColoredSurface(set, field);
  ASSERT_EQ(mesh.colors_srgb.size(), 3u);
  for (const auto& color : mesh.colors_srgb) {
    EXPECT_EQ(color, (std::array<uint8_t, 3>{255, 128, 255}));
  }
}

}  // namespace
}  // namespace tetrec
