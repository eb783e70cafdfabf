#include "mesh/tet_quality.h"

#include "core/random.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

using Corners = std::array<glm::dvec3, 4>;

Corners RegularTet(double size) {
  return {size * glm::dvec3(1, 1, 1), size * glm::dvec3(-1, 1, -1), size * glm::dvec3(1, -1, -1),
          size * glm::dvec3(-1, -1, 1)};
}

Corners RandomTet(Random& random, double size) {
  Corners corners;
  for (glm::dvec3& corner : corners) {
    for (int k = 0; k < 3; ++k) corner[k] = size * (2 * random.Uniform() - 1);
  }
  return corners;
}

TEST(ParthasarathyQuality, IsOneForARegularTetOfAnySizeAndMinusOneForItsMirrorImage) {
  for (const double size : {1e-12, 1.0, 1e9}) {
    Corners tet = RegularTet(size);
    const double quality = ParthasarathyQuality(tet);
    EXPECT_NEAR(std::abs(quality), 1.0, 1e-12);
    std::swap(tet[0], tet[1]);
    EXPECT_NEAR(ParthasarathyQuality(tet), -quality, 1e-12);
  }
  EXPECT_GT(ParthasarathyQuality({glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0),
                                  glm::dvec3(0, 0, 1)}),
            0.5);
}

TEST(ParthasarathyQuality, IsAtMostOneAndZeroWhereThereIsNoVolume) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_LT(std::abs(ParthasarathyQuality(RandomTet(random, 3.0))), 1.0);
  }
  EXPECT_EQ(ParthasarathyQuality({}), 0.0);
  EXPECT_EQ(ParthasarathyGradient({})[2], glm::dvec3(0.0));
  EXPECT_NEAR(ParthasarathyQuality({glm::dvec3(0, 0, 0), glm::dvec3(1, 0, 0), glm::dvec3(0, 1, 0),
                                    glm::dvec3(1, 1, 0)}),
              0.0, 1e-15);
}

// Central differences at a step h are off by some h^2 and by 1e-16 / h.
TEST(ParthasarathyGradient, AgreesWithFiniteDifferencesAtAnySize) {
  Random random(2);
  for (int i = 0; i < 200; ++i) {
    for (const double size : {1e-6, 1.0, 1e4}) {
      const Corners tet = RandomTet(random, size);
      const Corners gradient = ParthasarathyGradient(tet);
      const double step = 1e-5 * size;
      for (size_t corner = 0; corner < 4; ++corner) {
        for (int k = 0; k < 3; ++k) {
          Corners more = tet, less = tet;
          more[corner][k] += step;
          less[corner][k] -= step;
          const double slope =
              (ParthasarathyQuality(more) - ParthasarathyQuality(less)) / (2 * step);
          EXPECT_NEAR(size * gradient[corner][k], size * slope, 1e-6);
        }
      }
    }
  }
}

// Two tets over one face, the second one flat.
TetMesh OneFlatTet() {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.2f, 0.2f, 0.75f}, {0.3f, 0.3f, -0.0625f}};
  mesh.tets = {{0, 1, 2, 3}, {0, 2, 1, 4}};
  mesh.neighbors = ComputeNeighbors(mesh.tets, 5);
  return mesh;
}

TEST(QualityRegulariser, HasTheGradientOfItsValue) {
  for (const QualityRegulariser& regulariser :
       {QualityRegulariser{2.0, 10.0}, QualityRegulariser{10.0, 100.0},
        QualityRegulariser{0.1, 1.0}}) {
    const TetMesh mesh = OneFlatTet();
    const std::vector<glm::dvec3> gradients = RegulariserGradients(mesh, regulariser);
    for (size_t v = 0; v < 5; ++v) {
      for (int k = 0; k < 3; ++k) {
        constexpr float kStep = 0x1p-12f;
        TetMesh more = mesh, less = mesh;
        more.positions[v][k] += kStep;
        less.positions[v][k] -= kStep;
        // What floats make of the step.
        const double step = double(more.positions[v][k]) - double(less.positions[v][k]);
        const double slope =
            (RegulariserOf(more, regulariser) - RegulariserOf(less, regulariser)) / step;
        EXPECT_NEAR(gradients[v][k], slope, 1e-4 * regulariser.strength);
      }
    }
  }
}

TEST(QualityRegulariser, PullsAFlatTetOpenAndFeelsNoOverflow) {
  TetMesh mesh = OneFlatTet();
  const QualityRegulariser regulariser{1.0, 1e4};
  EXPECT_TRUE(std::isfinite(RegulariserOf(mesh, regulariser)));
  mesh.positions[4].z = 0.5f;  // inside out
  const double inside_out = RegulariserOf(mesh, regulariser);
  EXPECT_TRUE(std::isfinite(inside_out));
  // softplus(x) is close to x where it is sharp.
  const Corners corners = {glm::dvec3(0, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(1, 0, 0),
                           glm::dvec3(mesh.positions[4])};
  EXPECT_NEAR(inside_out, -ParthasarathyQuality(corners), 1e-3);
  const glm::dvec3 gradient = RegulariserGradients(mesh, regulariser)[4];
  EXPECT_GT(gradient.z, 0.0);  // down, out of the other tet, it falls
}

}  // namespace
}  // namespace tetrec
