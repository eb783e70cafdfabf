#include "render/seen_colors.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(PlacesOfRows, AreVerticesOrCentroids) {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0, 4}};
  mesh.tets = {{0, 1, 2, 3}};
  EXPECT_EQ(PlacesOfRows(mesh, FieldStorage::kVertex), mesh.positions);
  EXPECT_EQ(PlacesOfRows(mesh, FieldStorage::kCell), std::vector<glm::vec3>{glm::vec3(1.0f)});
}

}  // namespace
}  // namespace tetrec
