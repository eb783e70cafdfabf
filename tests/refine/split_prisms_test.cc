#include "refine/split_prisms.h"

#include "geometry/look_at.h"
#include "mesh/boundary.h"
#include "refine/refined_box.h"
#include "render/reference/reference_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

namespace tetrec {
namespace {

RefineOptions PrismOptions(PrismDiagonals diagonals = PrismDiagonals::kShorter) {
  RefineOptions options;
  options.scheme = RefineScheme::kPrism;
  options.diagonals = diagonals;
  return options;
}

TEST(SplitPrisms, KeepsMeshAndFieldSoundInManyRandomCases) {
  const uint64_t refused = ExpectSoundSplitsInManyRandomCases([](uint64_t seed) {
    return PrismOptions(seed % 2 ? PrismDiagonals::kFlips : PrismDiagonals::kShorter);
  });
  EXPECT_EQ(refused, 0u);
}

TEST(SplitPrisms, HalvesAllEdgesAtTheWorstVertex) {
  const TetMesh mesh = JitteredBox(4);
  for (uint32_t worst = 0; worst < mesh.positions.size(); worst += 7) {
    RefineScores scores = RandomScores(mesh);
    std::fill(scores.of_vertices.begin(), scores.of_vertices.end(), 0.0f);
    scores.of_vertices[worst] = 1.0f;
    size_t tets = 0;
    std::set<std::array<float, 3>> middles;
    for (const glm::uvec4& tet : mesh.tets) {
      bool is_at = false;
      for (int i = 0; i < 4; ++i) is_at |= tet[i] == worst;
      if (!is_at) continue;
      ++tets;
      for (int i = 0; i < 4; ++i) {
        if (tet[i] == worst) continue;
        const glm::vec3 middle = 0.5f * (mesh.positions[tet[i]] + mesh.positions[worst]);
        middles.insert({middle.x, middle.y, middle.z});
      }
    }
    const Refinement result = SplitPrisms(mesh, scores, PrismOptions());
    EXPECT_EQ(result.mesh.tets.size(), mesh.tets.size() + 3 * tets);
    EXPECT_EQ(result.split_edges, middles.size());
    ASSERT_EQ(result.of_vertices.kept.size(), result.mesh.positions.size());
    for (size_t v = 0; v < result.mesh.positions.size(); ++v) {
      const glm::vec3& p = result.mesh.positions[v];
      const bool is_new = result.of_vertices.kept[v] >= mesh.positions.size();
      EXPECT_EQ(is_new, middles.contains({p.x, p.y, p.z}));
    }
  }
}

TEST(SplitPrisms, KeepsToItsBudgetAndToItsShare) {
  const TetMesh mesh = JitteredBox(5);
  const size_t count = mesh.positions.size();
  RefineOptions options = PrismOptions();
  options.max_vertices = count + 40;
  const Refinement small = SplitPrisms(mesh, RandomScores(mesh), options);
  EXPECT_GT(small.mesh.positions.size(), count);
  EXPECT_LE(small.mesh.positions.size(), count + 40);
  options = PrismOptions();
  options.growth = 100;
  options.split_share = 1.5 / double(count);  // rounded up: two vertices
  EXPECT_EQ(SplitPrisms(mesh, RandomScores(mesh), options).mesh.tets.size() % 3,
            mesh.tets.size() % 3);
  options.split_share = 0;
  EXPECT_EQ(SplitPrisms(mesh, RandomScores(mesh), options).split_edges, 0u);
}

// The vertices of a ball are on no common plane, so no middle of an edge between them is exactly on
// its boundary.
TEST(SplitPrisms, RefusesWhatWouldRoughenTheBoundary) {
  std::vector<glm::vec3> points;
  Random random(4);
  for (int i = 0; i < 300; ++i) {
    glm::dvec3 p;
    do {
      for (int k = 0; k < 3; ++k) p[k] = 2 * random.Uniform() - 1;
    } while (glm::length(p) > 1);
    points.push_back(glm::vec3(i % 2 ? glm::normalize(p) : 0.8 * p));
  }
  const TetMesh mesh = BuildDelaunay(points).mesh;
  RefineOptions options = PrismOptions();
  options.growth = 100;
  const Refinement result = SplitPrisms(mesh, RandomScores(mesh), options);
  EXPECT_GT(result.refused, 50u);
  EXPECT_GT(result.split_edges, 500u);
  EXPECT_NO_THROW(CheckTetMesh(result.mesh));
  EXPECT_NO_THROW(CheckConvexDomain(result.mesh));
  EXPECT_EQ(MeasureQuality(result.mesh).boundary_faces, MeasureQuality(mesh).boundary_faces);
}

// Splits near one corner until edges have the length of a few roundings.
TEST(SplitPrisms, NeverFlattensATetHoweverDeepItGoes) {
  TetMesh mesh = GridBox(3);
  uint64_t refused = 0;
  for (int round = 0; round < 60; ++round) {
    RefineScores scores;
    for (const glm::vec3& p : mesh.positions) {
      scores.of_vertices.push_back(1 / (1e-9f + glm::distance(p, glm::vec3(0.3f, 0.2f, 0.1f))));
    }
    scores.of_tets.assign(mesh.tets.size(), 0.0f);
    RefineOptions options = PrismOptions();
    options.min_edge = 0;
    options.growth = 100;
    options.split_share = 3.0 / double(mesh.positions.size());
    Refinement next = SplitPrisms(std::move(mesh), scores, options);
    mesh = std::move(next.mesh);
    refused += next.refused;
  }
  EXPECT_GT(refused, 0u) << "the test does not go deep enough";
  EXPECT_NO_THROW(CheckTetMesh(mesh));
  EXPECT_NO_THROW(CheckConvexDomain(mesh));
}

TEST(SplitPrisms, StaysSoundForTwentyRounds) {
  TetMesh mesh = GridBox(4);
  FieldState state = RandomState(mesh, FieldStorage::kVertex);
  const TetMesh first_mesh = mesh;
  const FieldState first_state = state;
  for (uint64_t round = 0; round < 20; ++round) {
    RefineOptions options = PrismOptions();
    options.growth = 1.3;
    const RefineScores scores = RandomScores(mesh, round);
    RefineResult result = Refine(std::move(mesh), state, scores, options);
    mesh = std::move(result.mesh);
    state = std::move(result.state);
    EXPECT_NO_THROW(CheckTetMesh(mesh)) << "round " << round;
  }
  EXPECT_GT(mesh.positions.size(), 3000u);
  ExpectSoundBox(mesh);
  ExpectSameField(first_mesh, first_state, mesh, state);
}

TEST(SplitPrisms, LeavesThePictureAsItIs) {
  const TetMesh mesh = JitteredBox(4);
  const FieldState state = RandomState(mesh, FieldStorage::kVertex);
  RefineOptions options = PrismOptions();
  options.growth = 4.0;
  const RefineResult result = Refine(mesh, state, RandomScores(mesh), options);
  const auto renderer =
      CreateReferenceRenderer({.kind = RendererKind::kReference, .stop_transmittance = 1e-20f});
  const RenderView view{{40, 40, 40, 40, 20, 20},
                        CamLookingAt({2.3, 1.9, 1.4}, glm::dvec3(0.1, 0.0, -0.1))};
  renderer->SetField(FieldOf(mesh, state));
  const RenderedImage before = renderer->Render(view, 1);
  renderer->SetField(FieldOf(result.mesh, result.state));
  const RenderedImage after = renderer->Render(view, 1);
  double largest = 0;
  for (size_t i = 0; i < before.color_srgb.size(); ++i) {
    EXPECT_NEAR(after.transmittance[i], before.transmittance[i], 1e-5);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(after.color_srgb[i][c], before.color_srgb[i][c], 1e-5);
      largest = std::max(largest, double(before.color_srgb[i][c]));
    }
  }
  EXPECT_GT(largest, 0.3);
}

}  // namespace
}  // namespace tetrec
