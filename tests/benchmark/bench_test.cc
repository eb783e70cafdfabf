// Meshes of a given size, the choice of variants, and the table of results.
#include "benchmark/bench_report.h"
#include "benchmark/bench_run.h"
#include "core/error.h"
#include "field/change_storage.h"
#include "geometry/bounds3.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec::test {
namespace {

TEST(BenchScene, MeshesHaveAboutTheRequestedNumberOfTets) {
  for (uint64_t tets : {2'000u, 20'000u}) {
    const double made = double(BallFieldOfTets(tets).mesh.tets.size());
    EXPECT_NEAR(made / double(tets), 1.0, 0.25) << tets;
  }
  const RadianceField field = BallField(9);
  for (uint64_t tets : {1'000u, 12'000u}) {
    const RadianceField other = Resample(field, tets, 3);
    EXPECT_NEAR(double(other.mesh.tets.size()) / double(tets), 1.0, 0.25) << tets;
    CheckField(other);
    // The same hull.
    const Bounds3 a = BoundsOf(field.mesh.positions), b = BoundsOf(other.mesh.positions);
    EXPECT_EQ(a.min, b.min);
    EXPECT_EQ(a.max, b.max);
  }
}

TEST(BenchScene, ResamplingKeepsALinearField) {
  RadianceField field = BallField(6);
  for (size_t v = 0; v < field.density.size(); ++v) {
    field.density[v] = 1.0f + glm::dot(field.mesh.positions[v], glm::vec3(1, 2, 3));
    field.color_srgb[v] = field.mesh.positions[v];
  }
  for (uint64_t tets : {500u, 5'000u}) {
    const RadianceField other = Resample(field, tets, 4);
    for (size_t v = 0; v < other.density.size(); ++v) {
      const glm::vec3& p = other.mesh.positions[v];
      // Rounding of values up to 7.
      EXPECT_NEAR(other.density[v], 1.0f + glm::dot(p, glm::vec3(1, 2, 3)), 2e-6f);
      EXPECT_LT(glm::distance(other.color_srgb[v], p), 2e-7f);
    }
  }
}

// Rows of cells read by a vertex's index would be random rows: the mean difference between two
// densities of this field is 4 / 3.
TEST(BenchScene, ResamplingAFieldOfCellsIsResamplingItsVertices) {
  RadianceField field = BallField(8);
  for (size_t v = 0; v < field.density.size(); ++v) {
    field.density[v] = 1.0f + 4.0f * field.mesh.positions[v].x;
    field.color_srgb[v] = field.mesh.positions[v];
  }
  const RadianceField cells = WithStorage(field, FieldStorage::kCell);
  for (uint64_t tets : {1'000u, 8'000u}) {
    const RadianceField other = Resample(cells, tets, 4);
    const RadianceField expected = Resample(WithStorage(cells, FieldStorage::kVertex), tets, 4);
    CheckField(other);
    EXPECT_EQ(other.storage, FieldStorage::kVertex);
    EXPECT_EQ(other.density, expected.density);
    EXPECT_EQ(other.color_srgb, expected.color_srgb);
    double difference = 0;
    for (size_t v = 0; v < other.density.size(); ++v) {
      difference += std::abs(other.density[v] - (1.0f + 4.0f * other.mesh.positions[v].x));
    }
    EXPECT_LT(difference / double(other.density.size()), 0.5);
  }
}

BenchOptions SmallReferenceRun() {
  BenchOptions options;
  options.renderers = {"reference"};
  options.integrals = {"exact"};
  options.sizes = {8};
  options.error_size = 8;
  options.repeat = 1;
  return options;
}

TEST(BenchRun, MeshesHaveTheRequestedStorageOrTheFieldsOwn) {
  const RadianceField ball = BallField(3), cells = WithStorage(ball, FieldStorage::kCell);
  const std::vector<RenderView> views = ViewsAroundCube(2, 8);
  const auto measured = [&](const RadianceField* field, std::vector<uint64_t> tets,
                            std::optional<FieldStorage> storage) {
    BenchOptions options = SmallReferenceRun();
    options.tets = std::move(tets);
    options.storage = storage;
    const BenchResult result = RunBench(options, field, views);
    EXPECT_EQ(result.rows.size(), 1u);
    const FieldStorage made = result.rows[0].storage;
    const std::string word =
        made == FieldStorage::kCell ? "attributes per cell" : "attributes per vertex";
    EXPECT_NE(BenchTable(result).find(word), std::string::npos);
    return made;
  };
  for (const std::vector<uint64_t>& tets : {std::vector<uint64_t>{}, {400u}}) {
    EXPECT_EQ(measured(&cells, tets, {}), FieldStorage::kCell);
    EXPECT_EQ(measured(&cells, tets, FieldStorage::kVertex), FieldStorage::kVertex);
    EXPECT_EQ(measured(&ball, tets, {}), FieldStorage::kVertex);
    EXPECT_EQ(measured(&ball, tets, FieldStorage::kCell), FieldStorage::kCell);
  }
  EXPECT_EQ(measured(nullptr, {300u}, {}), FieldStorage::kVertex);
  EXPECT_EQ(measured(nullptr, {300u}, FieldStorage::kCell), FieldStorage::kCell);
}

// Options of some renderers are passed to these, and refused if there is none.
TEST(BenchRun, OptionsReachTheRenderersThatHaveThem) {
  BenchOptions options;
  options.renderers = {"march", "ppll", "reference"};
  options.integrals = {"exact"};
  options.renderer.device.device = "cpu";
  options.renderer.fragment_memory = 100ull << 20;
  const std::vector<BenchVariant> variants = VariantsOf(options);
  ASSERT_EQ(variants.size(), 3u);
  EXPECT_EQ(variants[0].options.device.device, "cpu");
  EXPECT_EQ(variants[1].options.fragment_memory, 100ull << 20);
  options.renderers = {"reference"};
  EXPECT_THROW(VariantsOf(options), UsageError);
  options.renderer.fragment_memory = RendererOptions().fragment_memory;
  EXPECT_THROW(VariantsOf(options), UsageError);
  options.renderer.device = {};
  EXPECT_EQ(VariantsOf(options).size(), 1u);
}

TEST(BenchScene, TheMiddleOfAViewKeepsItsDirections) {
  RenderView view = SquareView({3.0, 0.2, 0.1}, glm::dvec3(0.5), 64);
  view.camera = {80, 60, 70.0, 72.0, 41.0, 29.0};
  const RenderView middle = SquareMiddle(view, 120);
  // 60 pixels became 120: the centre (40, 30) of the image is at (60, 60).
  const glm::dvec3 before = view.camera.CamFromImage({40.0 + 10.0, 30.0 - 5.0});
  const glm::dvec3 after = middle.camera.CamFromImage({60.0 + 20.0, 60.0 - 10.0});
  EXPECT_LT(glm::distance(before, after), 1e-12);
}

TEST(BenchRun, TheFirstRendererTakesAllIntegralsTheOthersTheLast) {
  BenchOptions options;
  options.renderers = {"march", "projection"};
  options.integrals = {"mean", "split:4", "exact"};
  EXPECT_EQ(VariantsOf(options).size(), 3u + 2u);
  options.all_pairs = true;
  EXPECT_EQ(VariantsOf(options).size(), 3u + 2u * 3u);
  options.integrals = {"cubic"};
  EXPECT_THROW(VariantsOf(options), UsageError);
}

// The mean integral has errors; the reference has none relative to itself.
TEST(BenchRun, ErrorsAndTimesOfTheReferenceItself) {
  BenchOptions options;
  options.renderers = {"reference"};
  options.integrals = {"mean", "exact"};
  options.tets = {300};
  options.sizes = {16};
  options.error_size = 16;
  options.repeat = 2;
  const BenchResult result = RunBench(options, nullptr, {});
  ASSERT_EQ(result.rows.size(), 2u);
  for (const BenchRow& row : result.rows) {
    EXPECT_EQ(row.forward.wall.size(), 2u);
    EXPECT_EQ(row.positions.wall.size(), 2u);
    EXPECT_GT(row.steps_per_ray, 1.0);
    EXPECT_LT(row.steps_per_ray, 60.0);
  }
  EXPECT_GT(result.rows[0].errors.rms, 1e-5);  // the mean of the density is not the density
  EXPECT_GT(result.rows[0].errors.density, 1e-4);
  EXPECT_EQ(result.rows[1].errors.largest, 0.0);
  EXPECT_EQ(result.rows[1].errors.position, 0.0);
  const std::string table = BenchTable(result);
  EXPECT_NE(table.find("| reference, exact"), std::string::npos) << table;
}

}  // namespace
}  // namespace tetrec::test
