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
  const std::vector<NearestTriangle> nearest = NearestTriangles(points, mesh, 100, 1);
  for (size_t i = 0; i < points.size(); ++i) {
    EXPECT_NEAR(nearest[i].distance, expected[i], 1e-12) << i;
  }
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

TEST(MeshMetrics, AFlatTruthAndAReliefLeaveRoomBesideThem) {
  // Diagonal sqrt(2), threshold 0.01414; a cube of this diagonal grows by 0.0204 on each side.
  for (const double shift : {-0.013, 0.013, 0.019}) {
    const SurfaceScores scores = CompareSurfaces(Plane(7, 1, shift), Plane(10, 1, 0), FewSamples());
    EXPECT_EQ(scores.reconstruction_samples, 20000u) << shift;
    EXPECT_EQ(scores.f_score, shift < 0.01414 ? 1 : 0) << shift;
  }
  TriangleMesh relief = TestSphere(20, 1);
  for (glm::vec3& position : relief.positions) position.z *= 0.01f;
  const SurfaceScores scores = CompareSurfaces(relief, relief, FewSamples());
  const double cube_side = scores.diagonal / std::sqrt(3.0);
  EXPECT_NEAR(scores.crop.max.z, 0.01 + 0.025 * cube_side, 1e-6);
  EXPECT_NEAR(scores.crop.min.x, -1 - 0.025 * 2, 1e-2);
}

TEST(MeshMetrics, ABoxWithoutThinSidesGrowsByAFixedShare) {
  TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  mesh.triangles = {{0, 1, 2}, {0, 3, 1}, {1, 3, 2}, {0, 2, 3}};
  const Bounds3 crop = CompareSurfaces(mesh, mesh, FewSamples()).crop;
  EXPECT_LT(glm::distance(crop.min, glm::dvec3(-0.05)), 1e-12);
  EXPECT_LT(glm::distance(crop.max, glm::dvec3(2.05)), 1e-12);
}

TEST(MeshMetrics, EachDistanceHasItsOwnScore) {
  SurfaceScoreOptions options = FewSamples();
  options.bounds = Bounds3{glm::dvec3(-1), glm::dvec3(2)};
  // Half a threshold is 0.00707, a quarter 0.00354.
  const SurfaceScores scores = CompareSurfaces(Plane(7, 1, 0.005), Plane(10, 1, 0), options);
  ASSERT_EQ(scores.at_distances.size(), std::size(kThresholdShares));
  for (size_t i = 0; i < scores.at_distances.size(); ++i) {
    EXPECT_NEAR(scores.at_distances[i].threshold, kThresholdShares[i] * 0.01 * std::sqrt(2), 1e-6);
    EXPECT_EQ(scores.at_distances[i].f_score, kThresholdShares[i] >= 0.5 ? 1 : 0) << i;
  }
}

TEST(MeshMetrics, NormalsDifferByTheSlopeOfASawtoothAndByHalfATurnInsideOut) {
  // Teeth along x, so low that they are within the threshold, with slopes of 30 degrees.
  constexpr int kTeeth = 100;
  const double height = 0.5 / kTeeth * std::tan(M_PI / 6);
  TriangleMesh saw;
  for (int i = 0; i <= 2 * kTeeth; ++i) {
    for (const float y : {0.0f, 1.0f}) {
      saw.positions.emplace_back(0.5f * float(i) / kTeeth, y, i % 2 == 0 ? 0 : float(height));
    }
  }
  for (uint32_t i = 0; i < 2 * kTeeth; ++i) {
    saw.triangles.emplace_back(2 * i, 2 * i + 2, 2 * i + 1);
    saw.triangles.emplace_back(2 * i + 1, 2 * i + 2, 2 * i + 3);
  }
  const TriangleMesh truth = Plane(10, 1, 0);
  SurfaceScoreOptions options = FewSamples();
  options.bounds = Bounds3{glm::dvec3(-1), glm::dvec3(2)};
  EXPECT_NEAR(*CompareSurfaces(truth, truth, options).normal_angle_deg, 0, 1e-6);
  EXPECT_NEAR(*CompareSurfaces(saw, truth, options).normal_angle_deg, 30, 0.5);
  for (glm::uvec3& t : saw.triangles) std::swap(t.y, t.z);
  EXPECT_NEAR(*CompareSurfaces(saw, truth, options).normal_angle_deg, 150, 0.5);
  EXPECT_FALSE(CompareSurfaces(Plane(7, 1, 0.5), truth, options).normal_angle_deg);
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
