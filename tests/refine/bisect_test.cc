#include "refine/bisect.h"

#include "mesh/boundary.h"
#include "refine/refined_box.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetrec {
namespace {

RefineOptions BisectOptions(double growth = 2.0) {
  RefineOptions options;
  options.scheme = RefineScheme::kBisect;
  options.growth = growth;
  return options;
}

TEST(BisectTets, KeepsMeshAndFieldSoundInManyRandomCases) {
  ExpectSoundSplitsInManyRandomCases([](uint64_t) { return BisectOptions(); });
}

TEST(BisectTets, BisectsTheWorstTetAndFewOthers) {
  const TetMesh mesh = GridBox(5);
  for (size_t worst = 0; worst < mesh.tets.size(); worst += 31) {
    RefineScores scores = RandomScores(mesh);
    std::fill(scores.of_tets.begin(), scores.of_tets.end(), 0.0f);
    scores.of_tets[worst] = 1.0f;
    const Refinement result = BisectTets(mesh, scores, BisectOptions());
    EXPECT_GT(std::count(result.old_tets.begin(), result.old_tets.end(), uint32_t(worst)), 1);
    EXPECT_LE(result.split_edges, 8u);
    EXPECT_EQ(result.refused, 0u);
  }
}

// On a regular grid, longest edges lead to a few shapes of tets again and again.
TEST(BisectTets, KeepsTheQualityOfAGridRoundAfterRound) {
  TetMesh mesh = GridBox(3);
  double worst_of_first_rounds = 1.0;
  for (uint64_t round = 0; round < 15; ++round) {
    const RefineScores scores = RandomScores(mesh, round);
    mesh = BisectTets(std::move(mesh), scores, BisectOptions(1.4)).mesh;
    const double worst = MeasureQuality(mesh).min_radius_ratio;
    if (round < 8) worst_of_first_rounds = std::min(worst_of_first_rounds, worst);
    EXPECT_GT(worst, 0.5 * worst_of_first_rounds) << "round " << round;
  }
  EXPECT_GT(mesh.positions.size(), 3000u);
  ExpectSoundBox(mesh);
}

TEST(BisectTets, KeepsToTheBudgetAndSplitsNoShortEdge) {
  const TetMesh mesh = JitteredBox(5);
  RefineOptions options = BisectOptions(10);
  options.max_vertices = mesh.positions.size() + 7;
  EXPECT_EQ(BisectTets(mesh, RandomScores(mesh), options).split_edges, 7u);
  options = BisectOptions(10);
  options.min_edge = 10;
  const Refinement none = BisectTets(mesh, RandomScores(mesh), options);
  EXPECT_EQ(none.split_edges, 0u);
  EXPECT_EQ(none.refused, mesh.tets.size());
}

// Few middles of edges of the boundary are exactly on the boundary of a ball of points.
TEST(BisectTets, KeepsAnUnevenBoundaryConvex) {
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
  const Refinement result = BisectTets(mesh, RandomScores(mesh), BisectOptions(6));
  EXPECT_GT(result.split_edges, 1000u);
  EXPECT_NO_THROW(CheckTetMesh(result.mesh));
  EXPECT_NO_THROW(CheckConvexDomain(result.mesh));
  EXPECT_LT(double(MeasureQuality(result.mesh).boundary_faces),
            1.1 * double(MeasureQuality(mesh).boundary_faces));
}

}  // namespace
}  // namespace tetrec
