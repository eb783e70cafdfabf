#include "start/start_points.h"

#include "core/error.h"
#include "mesh/delaunay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tetrec {
namespace {

OccupancyGrid CarvedBall(int cells) {
  OccupancyGrid grid{{glm::dvec3(-1.2), glm::dvec3(1.2)}, glm::ivec3(cells), {}};
  grid.inside.assign(size_t(cells * cells * cells), 0);
  for (int z = 0; z < cells; ++z) {
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        grid.inside[grid.Index(x, y, z)] = glm::length(grid.CellCenter(x, y, z)) < 1;
      }
    }
  }
  return grid;
}

size_t CountOf(const StartPoints& points, VertexKind kind) {
  return size_t(std::count(points.kinds.begin(), points.kinds.end(), kind));
}

// Expects that the hull is the box with 12 triangles and no other vertex on it.
void ExpectBoxHull(const StartPoints& points) {
  ASSERT_EQ(points.positions.size(), points.kinds.size());
  ASSERT_EQ(points.positions.size(), points.point.size());
  const glm::vec3 low = points.positions[0], high = points.positions[7];
  EXPECT_EQ(CountOf(points, VertexKind::kCorner), 8u);
  for (size_t i = 8; i < points.positions.size(); ++i) {
    ASSERT_TRUE(glm::all(glm::lessThan(low, points.positions[i])));
    ASSERT_TRUE(glm::all(glm::lessThan(points.positions[i], high)));
  }
  const TetMesh mesh = BuildDelaunay(points.positions).mesh;
  CheckTetMesh(mesh);
  const TetMeshQuality quality = MeasureQuality(mesh);
  EXPECT_EQ(quality.boundary_faces, 12u);
  const glm::dvec3 size = glm::dvec3(high) - glm::dvec3(low);
  const double volume = size.x * size.y * size.z;
  EXPECT_NEAR(quality.total_volume, volume, 1e-11 * volume);  // sum of some 10^4 doubles
}

TEST(StartFromCarve, PutsVerticesWhereTheyAreNeeded) {
  const OccupancyGrid grid = CarvedBall(24);
  const StartPoints points = StartFromCarve(grid, {}, 1);
  ExpectBoxHull(points);
  size_t surface = 0;
  for (size_t i = 8; i < points.positions.size(); ++i) {
    const double radius = glm::length(points.positions[i]);
    // Half the diagonal of a cell is 0.087, the limit of the jittered vertex's distance from its
    // centre.
    if (points.kinds[i] == VertexKind::kInner) {
      EXPECT_LT(radius, 1);
    }
    if (points.kinds[i] == VertexKind::kSurface) {
      EXPECT_NEAR(radius, 0.95, 0.15);
      ++surface;
    }
    if (points.kinds[i] == VertexKind::kNear) {
      EXPECT_NEAR(radius, 1.1, 0.2);
    }
    if (points.kinds[i] == VertexKind::kOuter) {
      EXPECT_GT(radius, 0.95);
    }
  }
  EXPECT_GT(surface, 500u);
  EXPECT_EQ(CountOf(points, VertexKind::kOuter), 400u);
}

TEST(StartFromCarve, DependsOnTheSeedOnly) {
  const OccupancyGrid grid = CarvedBall(16);
  EXPECT_EQ(StartFromCarve(grid, {}, 5).positions, StartFromCarve(grid, {}, 5).positions);
  EXPECT_NE(StartFromCarve(grid, {}, 5).positions, StartFromCarve(grid, {}, 6).positions);
}

TEST(StartFromCarve, TakesASubjectThatFillsTheGrid) {
  OccupancyGrid grid{{glm::dvec3(0), glm::dvec3(1)}, glm::ivec3(3), {}};
  grid.inside.assign(27, 1);
  ExpectBoxHull(StartFromCarve(grid, {}, 1));
}

TEST(StartFromCarve, RefusesAnEmptyCarve) {
  OccupancyGrid grid = CarvedBall(8);
  grid.inside.assign(grid.inside.size(), 0);
  EXPECT_THROW(StartFromCarve(grid, {}, 1), DataError);
}

TEST(StartFromGrid, FillsTheBox) {
  const StartPoints points = StartFromGrid({{-1, -2, -3}, {1, 2, 3}}, 12, 1);
  ExpectBoxHull(points);
  EXPECT_EQ(points.positions.size(), 8u + 4 * 8 * 12);
}

TEST(FilterPoints, CountsWhatItDropsOnce) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<SparsePoint> points = {{{0, 0, 0}, 0.5f, 5},     {{nan, 0, 0}, 9.0f, 1},
                                           {{1, 0, 0}, 2.5f, 1},     {{2, 0, 0}, 0.5f, 2},
                                           {{0.001, 0, 0}, 0.5f, 9}, {{0, 1, 0}, 0.5f, 3}};
  const FilteredPoints filtered = FilterPoints(points, {});
  EXPECT_EQ(filtered.kept, (std::vector<uint32_t>{4, 5}))
      << "the longest track among close points is kept";
  EXPECT_EQ(filtered.not_finite, 1u);
  EXPECT_EQ(filtered.high_error, 1u);
  EXPECT_EQ(filtered.short_track, 1u);
  EXPECT_EQ(filtered.too_close, 1u);
}

TEST(FilterPoints, LeavesNoTwoPointsCloserThanTheSpacing) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<SparsePoint> points;
  for (int i = 0; i < 1000; ++i) {
    const double x = unit(random), y = unit(random), z = unit(random);
    points.push_back({{x, y, z}, 1.0f, 3});
  }
  const double spacing = 0.15;
  const FilteredPoints filtered = FilterPoints(points, {2.0, 3, spacing});
  EXPECT_EQ(filtered.kept.size() + filtered.too_close, 1000u);
  EXPECT_GT(filtered.too_close, 100u);
  for (const uint32_t i : filtered.kept) {
    for (const uint32_t j : filtered.kept) {
      if (i == j) continue;
      ASSERT_GE(glm::distance(points[i].position, points[j].position), spacing);
    }
  }
}

TEST(StartFromPoints, EnclosesEveryCameraAndReportsFarPoints) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  std::vector<glm::dvec3> positions, cameras;
  for (int i = 0; i < 500; ++i) {
    const double x = normal(random), y = normal(random), z = normal(random);
    positions.push_back(0.5 * glm::dvec3(x, y, z));
  }
  positions.push_back({1e6, 0, 0});
  for (int i = 0; i < 20; ++i) cameras.push_back({3 * std::cos(i), 3 * std::sin(i), 1});
  const Bounds3 subject{glm::dvec3(-1), glm::dvec3(1)};
  const PointStart start = StartFromPoints(positions, cameras, subject, {}, 1);
  ExpectBoxHull(start.points);
  EXPECT_EQ(start.dropped_far, 1u);
  EXPECT_EQ(CountOf(start.points, VertexKind::kSurface), 500u);
  EXPECT_EQ(start.fill + 500 + 8, start.points.positions.size());
  for (const glm::dvec3& camera : cameras) EXPECT_LT(glm::length(camera), 0.7 * start.far_radius);
  for (size_t i = 0; i < start.points.positions.size(); ++i) {
    const glm::vec3& p = start.points.positions[i];
    if (start.points.point[i] != kNoPoint) {
      EXPECT_EQ(p, glm::vec3(positions[start.points.point[i]]));
    }
    if (start.points.kinds[i] == VertexKind::kFar) {
      EXPECT_NEAR(glm::length(p), start.far_radius, 1e-5 * start.far_radius);  // float rounding
    }
  }
}

// So the sky hardly shifts from camera to camera, and few vertices are spent on the way to it.
TEST(StartFromPoints, ReachesFarBeyondTheCamerasByFewVertices) {
  const std::vector<glm::dvec3> cameras = {{8, 0, 0}, {-8, 0, 0}};
  const PointStart start = StartFromPoints({}, cameras, {glm::dvec3(-1), glm::dvec3(1)}, {}, 1);
  EXPECT_GE(start.far_radius, 160.0);
  size_t beyond = 0, between = 0;
  for (const glm::vec3& p : start.points.positions) {
    const double radius = glm::length(glm::dvec3(p));
    beyond += radius > 15;
    between += radius > 20 && radius < 100;
  }
  EXPECT_LT(beyond, 2700u);  // the shell has 800
  EXPECT_GT(between, 300u);
}

TEST(StartFromPoints, FillsEvenlyInProportionToTheDistance) {
  const std::vector<glm::dvec3> cameras = {{8, 0, 0}};
  const PointStart start = StartFromPoints({}, cameras, {glm::dvec3(-1), glm::dvec3(1)}, {}, 1);
  ExpectBoxHull(start.points);
  // Each doubling of the radius contains as many vertices.
  size_t counts[3] = {0, 0, 0};
  for (const glm::vec3& p : start.points.positions) {
    const double octave = std::log2(glm::length(glm::dvec3(p)) / 1.5);
    if (octave > 0 && octave < 3) ++counts[size_t(octave)];
  }
  EXPECT_GT(counts[0], 500u);
  EXPECT_NEAR(double(counts[1]) / double(counts[0]), 1,
              0.35);  // whole spheres: one of three may slip
}

TEST(StartFromPoints, RefusesASceneWithoutCamerasOrBounds) {
  const std::vector<glm::dvec3> cameras = {{8, 0, 0}};
  EXPECT_THROW(StartFromPoints({}, {}, {glm::dvec3(-1), glm::dvec3(1)}, {}, 1), DataError);
  EXPECT_THROW(StartFromPoints({}, cameras, {}, {}, 1), DataError);
}

}  // namespace
}  // namespace tetrec
