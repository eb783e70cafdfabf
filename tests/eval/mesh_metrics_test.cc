#include "eval/mesh_metrics.h"

#include "core/error.h"
#include "eval/fake_run.h"
#include "expect_error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

SurfaceScoreOptions FewSamples() {
  SurfaceScoreOptions options;
  options.samples = 20000;
  return options;
}

TEST(MeshMetrics, SamplesSpreadByAreaAndLieOnTheirTriangles) {
  // Two separate triangles, the second with three times the area.
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {5, 0, 1}, {8, 0, 1}, {5, 1, 1}};
  mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
  const SurfaceSamples samples = SampleSurface(mesh, 4000, 3);
  ASSERT_EQ(samples.positions.size(), 4000u);
  size_t on_first = 0;
  glm::dvec3 mean(0.0);
  for (size_t i = 0; i < 4000; ++i) {
    const bool first = samples.triangles[i] == 0;
    on_first += first;
    if (!first) mean += samples.positions[i];
    EXPECT_NEAR(samples.positions[i].z, first ? 0 : 1, 1e-15);  // rounding of the weights' sum
  }
  EXPECT_EQ(on_first, 1000u);  // stratified: one sample for each 1/4000 of the area
  mean /= 3000.0;
  // Centre of the triangle; standard deviation of the mean is 3 / sqrt(18 * 3000) = 0.013 in x.
  EXPECT_NEAR(mean.x, 6, 0.06);
  EXPECT_NEAR(mean.y, 1 / 3.0, 0.02);
}

TEST(MeshMetrics, TheSameSeedGivesTheSameSamples) {
  const TriangleMesh sphere = TestSphere(8, 1);
  EXPECT_EQ(SampleSurface(sphere, 100, 5).positions, SampleSurface(sphere, 100, 5).positions);
  EXPECT_NE(SampleSurface(sphere, 100, 5).positions, SampleSurface(sphere, 100, 6).positions);
}

TEST(MeshMetrics, DistancesToATriangleAreThoseOfItsFaceEdgesAndCorners) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles = {{0, 1, 2}};
  const std::vector<glm::dvec3> points = {
      {0.2, 0.2, -3}, {0.5, -2, 0}, {1, 1, 0}, {-3, -4, 0}, {2, 0, 0}};
  const std::vector<double> expected = {3, 2, std::sqrt(0.5), 5, 1};
  const std::vector<double> distances = DistancesToSurface(points, mesh, 100, 1);
  for (size_t i = 0; i < points.size(); ++i) EXPECT_NEAR(distances[i], expected[i], 1e-12) << i;
}

TEST(MeshMetrics, AMeshAgainstItselfScoresOneAtNoDistance) {
  const TriangleMesh sphere = TestSphere(30, 2);
  const SurfaceScores scores = CompareSurfaces(sphere, sphere, FewSamples());
  EXPECT_EQ(scores.f_score, 1);
  EXPECT_EQ(scores.precision, 1);
  EXPECT_EQ(scores.recall, 1);
  // The nearest triangle may be missed where triangles are narrower than the samples' spacing of
  // sqrt(16 pi / 20000) = 0.05; a neighbour then takes its place, a thousandth of that away on
  // average.
  EXPECT_LT(*scores.chamfer, 5e-5);
  EXPECT_NEAR(scores.diagonal, 2 * 2 * std::sqrt(3),
              0.01);  // the sphere's box, up to its polygons
}

TEST(MeshMetrics, AShiftedPlaneIsAsFarAsTheShift) {
  const TriangleMesh truth = Plane(10, 1, 0);
  SurfaceScoreOptions options = FewSamples();
  options.bounds = Bounds3{glm::dvec3(-1), glm::dvec3(2)};
  for (const double shift : {0.002, 0.01, 0.05}) {
    const SurfaceScores scores = CompareSurfaces(Plane(7, 1, shift), truth, options);
    // The planes overlap wholly, so the nearest point is straight below; positions are floats
    // (6e-8), and the nearest triangle may be missed at an edge (see above).
    EXPECT_NEAR(*scores.accuracy, shift, 1e-6);
    EXPECT_NEAR(*scores.completeness, shift, 1e-6);
    EXPECT_NEAR(*scores.chamfer, shift, 1e-6);
    // Diagonal sqrt(2), threshold 0.01414.
    EXPECT_EQ(scores.f_score, shift < 0.01414 ? 1 : 0) << shift;
  }
}

TEST(MeshMetrics, HalfOfThePlaneHasFullPrecisionAndHalfTheRecall) {
  TriangleMesh half = Plane(10, 1, 0);
  for (glm::vec3& position : half.positions) position.x *= 0.5f;
  const SurfaceScores scores = CompareSurfaces(half, Plane(10, 1, 0), FewSamples());
  EXPECT_EQ(scores.precision, 1);
  // Half, and the strip of one threshold (0.01 sqrt(2)) beyond it; 20,000 stratified samples.
  const double recall = 0.5 + 0.01 * std::sqrt(2);
  EXPECT_NEAR(scores.recall, recall, 0.01);
  EXPECT_NEAR(scores.f_score, 2 * recall / (1 + recall), 0.01);
}

TEST(MeshMetrics, PartsOutsideTheBoxAreNotScored) {
  TriangleMesh with_table = TestSphere(30, 1);
  const auto first = uint32_t(with_table.positions.size());
  const TriangleMesh table = Plane(4, 40, -3);
  for (const glm::vec3& position : table.positions) with_table.positions.push_back(position);
  for (const glm::uvec3& triangle : table.triangles)
    with_table.triangles.push_back(triangle + first);
  const SurfaceScores scores = CompareSurfaces(with_table, TestSphere(30, 1), FewSamples());
  EXPECT_EQ(scores.f_score, 1);
  // The far table took none of the samples.
  EXPECT_EQ(scores.reconstruction_samples, 20000u);
}

TEST(MeshMetrics, NothingInsideTheBoxScoresZeroWithoutDistances) {
  const SurfaceScores scores =
      CompareSurfaces(TestSphere(8, 1, {50, 0, 0}), TestSphere(8, 1), FewSamples());
  EXPECT_EQ(scores.f_score, 0);
  EXPECT_FALSE(scores.accuracy.has_value());
  EXPECT_FALSE(scores.chamfer.has_value());
  EXPECT_EQ(CompareSurfaces({}, TestSphere(8, 1), FewSamples()).f_score, 0);
}

TEST(MeshMetrics, ATruthWithoutSurfaceInTheBoxIsRefused) {
  ExpectError<DataError>([] { CompareSurfaces(TestSphere(8, 1), {}, FewSamples()); },
                         {"ground-truth"});
  ExpectError<DataError>([] { SampleSurface({}, 10, 1); }, {"0 triangles"});
}

}  // namespace
}  // namespace tetrec
