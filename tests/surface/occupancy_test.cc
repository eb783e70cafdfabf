#include "surface/occupancy.h"

#include "core/random.h"
#include "mesh/delaunay.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetrec {
namespace {

TetMesh RandomMesh(int vertices) {
  Random random(3);
  std::vector<glm::vec3> points;
  for (int i = 0; i < vertices; ++i) {
    const float x = float(random.Uniform()), y = float(random.Uniform());
    points.emplace_back(x, y, float(random.Uniform()));
  }
  return BuildDelaunay(points).mesh;
}

TEST(SmoothedOccupancy, IsOneHalfAtTheIsovalueAndGrowsWithDensity) {
  const TetMesh mesh = RandomMesh(4);
  const std::vector<float> density = {0.0f, 3.0f, 30.0f, 1e30f};
  const std::vector<float> occupancy = SmoothedOccupancy(mesh, density, 3.0, 0);
  EXPECT_EQ(occupancy[0], 0.0f);
  EXPECT_EQ(occupancy[1], kSurfaceOccupancy);
  EXPECT_GT(occupancy[2], kSurfaceOccupancy);
  EXPECT_EQ(occupancy[3], 1.0f);
}

TEST(SmoothedOccupancy, OfConstantDensityIsConstant) {
  const TetMesh mesh = RandomMesh(100);
  for (const float o : SmoothedOccupancy(mesh, std::vector<float>(100, 6.0f), 2.0, 5)) {
    EXPECT_FLOAT_EQ(o, 0.75f);
  }
}

// Neither side outweighs the other, so averaging moves no surface.
TEST(SmoothedOccupancy, OfSignedDensityIsAsFarFromOneHalfBelowAsAbove) {
  const TetMesh mesh = RandomMesh(4);
  for (const float above : {0.5f, 3.0f, 1000.0f}) {
    std::vector<float> density(mesh.positions.size(), 2.0f);
    density[0] = 2 + above;
    density[1] = 2 - above;
    density[2] = -1;
    const std::vector<float> occupancy = SmoothedOccupancy(mesh, density, 2.0, 0);
    EXPECT_NEAR(occupancy[0] + occupancy[1], 1.0f, 1e-6f);
    EXPECT_GT(occupancy[0], 0.5f);
    EXPECT_EQ(occupancy[3], kSurfaceOccupancy);
  }
}

TEST(SmoothedOccupancy, OneFullVertexInFreeSpaceIsNoSurface) {
  const TetMesh mesh = RandomMesh(300);
  std::vector<float> density(300, 0.0f);
  density[150] = 1e6f;
  EXPECT_GT(SmoothedOccupancy(mesh, density, 1.0, 0)[150], kSurfaceOccupancy);
  const std::vector<float> occupancy = SmoothedOccupancy(mesh, density, 1.0, 2);
  EXPECT_LT(*std::max_element(occupancy.begin(), occupancy.end()), kSurfaceOccupancy);
}

TEST(SmoothedOccupancy, OfOneTetAveragesEachCornerWithTheOthers) {
  const TetMesh mesh = RandomMesh(4);
  const std::vector<float> occupancy =
      SmoothedOccupancy(mesh, std::vector<float>{1.0f, 0.0f, 0.0f, 0.0f}, 1.0, 1);
  EXPECT_FLOAT_EQ(occupancy[0], 0.25f);
  for (int i = 1; i < 4; ++i) EXPECT_FLOAT_EQ(occupancy[i], 0.5f / 3 / 2);
}

}  // namespace
}  // namespace tetrec
