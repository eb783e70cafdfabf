#include "surface/simplify.h"

#include "core/error.h"
#include "core/random.h"
#include "mesh/mesh_facts.h"
#include "sanitized.h"
#include "surface/clean.h"
#include "surface/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tetrec {
namespace {

void ExpectColoursOfTheirVertices(const TriangleMesh& part, const TriangleMesh& whole) {
  ASSERT_EQ(part.colors_srgb.size(), part.positions.size());
  for (size_t v = 0; v < part.positions.size(); ++v) {
    const auto& c = part.colors_srgb[v];
    ASSERT_EQ(whole.positions[size_t(c[0] | c[1] << 8)], part.positions[v]);
  }
}

// Share of triangles that are more than ten times as long as they are high.
double SliverShare(const TriangleMesh& mesh) {
  size_t slivers = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]), b(mesh.positions[t.y]), c(mesh.positions[t.z]);
    const double longest =
        std::max({glm::distance(a, b), glm::distance(b, c), glm::distance(c, a)});
    slivers += longest * longest > 10 * glm::length(glm::cross(b - a, c - a));
  }
  return double(slivers) / double(mesh.triangles.size());
}

// The mean distance of a mesh from the unit sphere, over its area: at the centres of the 36
// triangles into which lines parallel to the sides part each triangle.
double MeanDistanceFromSphere(const TriangleMesh& mesh) {
  constexpr int kParts = 6;
  double sum = 0, whole = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t.x]), u = glm::dvec3(mesh.positions[t.y]) - a,
                                             v = glm::dvec3(mesh.positions[t.z]) - a;
    const double area = glm::length(glm::cross(u, v)) / 2;
    const auto add = [&](double i, double k) {
      const double distance = std::abs(glm::length(a + (i * u + k * v) / double(kParts)) - 1);
      sum += area / (kParts * kParts) * distance;
    };
    for (int i = 0; i < kParts; ++i) {
      for (int k = 0; i + k < kParts; ++k) {
        add(i + 1.0 / 3, k + 1.0 / 3);
        if (i + k + 1 < kParts) add(i + 2.0 / 3, k + 2.0 / 3);
      }
    }
    whole += area;
  }
  return sum / whole;
}

TEST(Simplify, StaysWithinTheDeviationWithFewerAndBetterTriangles) {
  const TriangleMesh sphere = Sphere(1, {0, 0, 0});
  constexpr double kDeviation = 0.01;
  const TriangleMesh simple = Simplify(sphere, kDeviation);
  EXPECT_LT(simple.triangles.size(), 0.5 * double(sphere.triangles.size()));
  const MeshFacts facts = MeasureMesh(simple);
  EXPECT_TRUE(facts.IsClosedManifold());
  EXPECT_EQ(facts.euler_characteristic, 2);
  EXPECT_LT(MeanDistanceFromSphere(simple), MeanDistanceFromSphere(sphere) + kDeviation);
  EXPECT_GT(SliverShare(sphere), 0.05);
  EXPECT_LT(SliverShare(simple), 0.2 * SliverShare(sphere));
  ExpectColoursOfTheirVertices(simple, sphere);
  EXPECT_EQ(Simplify(sphere, 0).triangles, sphere.triangles);
}

// A surface from photos is rough: by half a percent of the diagonal here. The default deviation
// leaves its error as it is.
TEST(Simplify, LeavesTheErrorOfARoughSurfaceAsItIs) {
  TriangleMesh rough = Sphere(1, {0, 0, 0});
  const double diagonal = 2 * std::sqrt(3);
  for (size_t v = 0; v < rough.positions.size(); ++v) {
    rough.positions[v] *= float(1 + 0.005 * diagonal * std::sin(double(v * v % 1013)));
  }
  const TriangleMesh simple = Simplify(rough, 0.0005 * diagonal);
  EXPECT_LT(simple.triangles.size(), 0.9 * double(rough.triangles.size()));
  EXPECT_NEAR(MeanDistanceFromSphere(simple) / MeanDistanceFromSphere(rough), 1, 0.05);
  const TriangleMesh half = Decimate(simple, rough.triangles.size() / 2);
  EXPECT_NEAR(MeanDistanceFromSphere(half) / MeanDistanceFromSphere(rough), 1, 0.05);
}

// A flat square keeps its four corners, and nothing else that it does not need.
TEST(Simplify, KeepsTheOutlineOfAFlatSheet) {
  TriangleMesh sheet;
  constexpr uint32_t kSide = 21;
  for (uint32_t y = 0; y < kSide; ++y) {
    for (uint32_t x = 0; x < kSide; ++x) sheet.positions.emplace_back(x, y, 0);
  }
  for (uint32_t y = 0; y + 1 < kSide; ++y) {
    for (uint32_t x = 0; x + 1 < kSide; ++x) {
      const uint32_t id = y * kSide + x;
      sheet.triangles.emplace_back(id, id + 1, id + kSide + 1);
      sheet.triangles.emplace_back(id, id + kSide + 1, id + kSide);
    }
  }
  const TriangleMesh simple = Simplify(sheet, 0.01);
  EXPECT_NEAR(MeasureMesh(simple).area, 400, 1);
  EXPECT_LT(simple.triangles.size(), sheet.triangles.size() / 4);
}

// Level sets of random values are full of narrow tubes and of holes with few edges.
TEST(Simplify, AndDecimateKeepTheTopologyOfTubesAndSheets) {
  const TetMesh mesh = JitteredBox(12);
  MersenneRandom random(5);
  for (int turn = 0; turn < (kIsSanitized ? 2 : 10); ++turn) {
    const bool open = turn % 2 == 1;  // then the level set ends at the box
    const std::vector<float> values = Sampled(mesh, [&](const glm::dvec3& p) {
      return open || Ball(p / 1.4) > 0 ? random.Uniform() - 0.5 : -1.0;
    });
    const TriangleMesh tubes = SeparateFans(AsTriangles(MarchTetrahedra(mesh, values, 0)));
    const MeshFacts before = MeasureMesh(tubes);
    // Nothing but the topology ends the second.
    for (const TriangleMesh& simple : {Simplify(tubes, 0.05), Decimate(tubes, 1)}) {
      EXPECT_LT(simple.triangles.size(), 0.8 * double(tubes.triangles.size()));
      const MeshFacts facts = MeasureMesh(simple);
      EXPECT_EQ(facts.boundary_edges > 0, open);
      EXPECT_EQ(facts.non_manifold_edges, 0u);
      EXPECT_EQ(facts.non_manifold_vertices, 0u);
      EXPECT_EQ(facts.components, before.components);
      EXPECT_EQ(facts.euler_characteristic, before.euler_characteristic);
    }
  }
}

TEST(Decimate, KeepsShapeTopologyAndColours) {
  const TriangleMesh sphere = Sphere(1, {0, 0, 0});
  const TriangleMesh small = Decimate(sphere, sphere.triangles.size() / 4);
  EXPECT_LE(small.triangles.size(), sphere.triangles.size() / 4);
  EXPECT_GT(small.triangles.size(), sphere.triangles.size() / 5);
  const MeshFacts facts = MeasureMesh(small);
  EXPECT_TRUE(facts.IsClosedManifold());
  EXPECT_EQ(facts.euler_characteristic, 2);
  // Edges become twice as long, so the volume lost by flat triangles (1.7 % before) grows about
  // four times.
  EXPECT_NEAR(facts.volume, MeasureMesh(sphere).volume, 0.07 * 4 * std::numbers::pi / 3);
  ExpectColoursOfTheirVertices(small, sphere);
  EXPECT_EQ(Decimate(sphere, sphere.triangles.size()).triangles, sphere.triangles);
}

TEST(Decimate, RefusesASurfaceThatIsNotAManifold) {
  TriangleMesh book;
  book.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}};
  book.triangles = {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}};
  EXPECT_THROW(Decimate(book, 1), DataError);
}

}  // namespace
}  // namespace tetrec
