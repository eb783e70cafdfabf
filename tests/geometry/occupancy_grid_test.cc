// Occupancy grids: cells, counts and bounds.
#include "geometry/occupancy_grid.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

OccupancyGrid SomeGrid() {
  OccupancyGrid grid{{{-1, 0, 2}, {3, 2, 5}}, {8, 4, 3}, {}};
  grid.inside.assign(8 * 4 * 3, 0);
  return grid;
}

TEST(OccupancyGrid, FindsTheCellOfItsOwnCentres) {
  const OccupancyGrid grid = SomeGrid();
  size_t index = 0;
  for (int z = 0; z < 3; ++z) {
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < 8; ++x) {
        EXPECT_EQ(grid.CellOf(grid.CellCenter(x, y, z)), glm::ivec3(x, y, z));
        EXPECT_EQ(grid.Index(x, y, z), index++);
      }
    }
  }
}

TEST(OccupancyGrid, InsideBoundsWrapTheInsideCells) {
  OccupancyGrid grid = SomeGrid();
  EXPECT_TRUE(grid.InsideBounds().IsEmpty());
  grid.inside[grid.Index(2, 1, 0)] = 1;
  grid.inside[grid.Index(3, 3, 1)] = 1;
  EXPECT_EQ(grid.InsideCount(), 2u);
  EXPECT_EQ(grid.InsideBounds().min, glm::dvec3(0, 0.5, 2));
  EXPECT_EQ(grid.InsideBounds().max, glm::dvec3(1, 2, 4));
}

TEST(OccupancyGrid, IsOutsideBeyondItsBox) {
  OccupancyGrid grid = SomeGrid();
  grid.inside.assign(grid.inside.size(), 1);
  EXPECT_TRUE(grid.Inside({7, 3, 2}));
  EXPECT_FALSE(grid.Inside({8, 3, 2}));
  EXPECT_FALSE(grid.Inside({0, -1, 0}));
}

TEST(CubicCells, MakesTheLongestSideFullAndCellsAboutCubes) {
  EXPECT_EQ(CubicCells({{0, 0, 0}, {4, 2, 1}}, 64), glm::ivec3(64, 32, 16));
  EXPECT_EQ(CubicCells({{0, 0, 0}, {4, 2, 0.001}}, 64), glm::ivec3(64, 32, 1));
}

}  // namespace
}  // namespace tetrec
