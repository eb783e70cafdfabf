// Attributes moved between vertices and cells.
#include "field/change_storage.h"

#include "field/extra_attribute.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

// Two tets of volumes 1/6 and 1/3 that share the face 1 2 3.
TetMesh TwoTets() {
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}};
  mesh.tets = {{0, 1, 2, 3}, {4, 1, 3, 2}};
  mesh.neighbors = {{1, kNoTet, kNoTet, kNoTet}, {0, kNoTet, kNoTet, kNoTet}};
  CheckTetMesh(mesh);
  return mesh;
}

TEST(WithStorage, LeavesAFieldOfThatStorageAsItIs) {
  const RadianceField field{TwoTets(), {1, 2, 3, 4, 5}, std::vector<glm::vec3>(5, glm::vec3(0.1f))};
  const RadianceField same = WithStorage(field, FieldStorage::kVertex);
  EXPECT_EQ(same.density, field.density);
  EXPECT_EQ(same.color_srgb, field.color_srgb);
}

TEST(WithStorage, GivesACellTheMeanDensityAndTheColourOfItsDenseVertices) {
  RadianceField field{TwoTets(), {0, 0, 0, 4, 8}, std::vector<glm::vec3>(5, glm::vec3(0.25f))};
  field.color_srgb[3] = {1, 0, 0};
  field.color_srgb[4] = {0, 1, 0};
  const RadianceField cells = WithStorage(field, FieldStorage::kCell);
  EXPECT_EQ(cells.storage, FieldStorage::kCell);
  EXPECT_EQ(cells.density, (std::vector<float>{1, 3}));
  EXPECT_EQ(cells.color_srgb[0], glm::vec3(1, 0, 0)) << "only vertex 3 shows";
  EXPECT_LT(glm::distance(cells.color_srgb[1], glm::vec3(1, 2, 0) / 3.0f), 1e-6f);
  EXPECT_NO_THROW(CheckField(cells));
}

TEST(WithStorage, GivesNoCellANegativeDensity) {
  RadianceField field{TwoTets(), {-9, 1, -2, 2, 7}, std::vector<glm::vec3>(5, glm::vec3(0.25f))};
  field.color_srgb[3] = {1, 0, 0};
  const RadianceField cells = WithStorage(field, FieldStorage::kCell);
  EXPECT_EQ(cells.density, (std::vector<float>{0, 2}));
  EXPECT_NO_THROW(CheckField(cells));
}

TEST(WithStorage, GivesAVertexTheMeanOfItsCellsByVolume) {
  RadianceField field{TwoTets(), {3, 6}, {{1, 0, 0}, {0, 0, 1}}, FieldStorage::kCell};
  const RadianceField vertices = WithStorage(field, FieldStorage::kVertex);
  EXPECT_EQ(vertices.storage, FieldStorage::kVertex);
  EXPECT_EQ(vertices.density[0], 3.0f);
  EXPECT_EQ(vertices.density[4], 6.0f);
  for (int v = 1; v <= 3; ++v) {
    EXPECT_NEAR(vertices.density[v], (3.0 * 1 + 6.0 * 2) / 3.0, 1e-6) << "volumes 1 : 2";
    EXPECT_LT(glm::distance(vertices.color_srgb[v], glm::vec3(3, 0, 12) / 15.0f), 1e-6f);
  }
}

TEST(WithStorage, KeepsColoursWhereAllIsEmpty) {
  RadianceField field{TwoTets(), {0, 0}, {{1, 0, 0}, {0, 0, 1}}, FieldStorage::kCell};
  const RadianceField vertices = WithStorage(field, FieldStorage::kVertex);
  EXPECT_EQ(vertices.density, std::vector<float>(5, 0.0f));
  EXPECT_EQ(vertices.color_srgb[0], glm::vec3(1, 0, 0));
  EXPECT_LT(glm::distance(vertices.color_srgb[1], glm::vec3(1, 0, 2) / 3.0f), 1e-6f);
}

TEST(WithStorage, TreatsOtherAttributesAsColourIsTreated) {
  RadianceField field{TwoTets(), {0, 0, 0, 4, 8}, std::vector<glm::vec3>(5, glm::vec3(0.25f))};
  field.others = {{kExtraAttribute, std::vector<float>(25, 1.0f)}};
  field.others[0].values[3 * 5 + 2] = -6.0f;
  field.others[0].values[4 * 5 + 2] = 3.0f;
  const RadianceField cells = WithStorage(field, FieldStorage::kCell);
  EXPECT_NO_THROW(CheckField(cells));
  ASSERT_EQ(cells.others.size(), 1u);
  EXPECT_EQ(cells.others[0].attribute, kExtraAttribute);
  EXPECT_EQ(cells.others[0].values, (std::vector<float>{1, 1, -6, 1, 1, 1, 1, 0, 1, 1}));
  const RadianceField vertices = WithStorage(cells, FieldStorage::kVertex);
  EXPECT_NO_THROW(CheckField(vertices));
  EXPECT_EQ(vertices.others[0].values[2], -6.0f) << "one cell only";
  // Volumes 1 : 2, densities 1 : 3.
  EXPECT_FLOAT_EQ(vertices.others[0].values[1 * 5 + 2], (1 * -6.0f + 6 * 0.0f) / 7.0f);
}

TEST(WithStorage, LeavesAConstantFieldConstant) {
  const RadianceField field{TwoTets(), std::vector<float>(5, 2.5f),
                            std::vector<glm::vec3>(5, glm::vec3(0.3f, 0.6f, 0.9f))};
  const RadianceField back =
      WithStorage(WithStorage(field, FieldStorage::kCell), FieldStorage::kVertex);
  for (int v = 0; v < 5; ++v) {
    EXPECT_NEAR(back.density[v], 2.5f, 1e-6f);
    EXPECT_LT(glm::distance(back.color_srgb[v], field.color_srgb[v]), 1e-6f);
  }
}

}  // namespace
}  // namespace tetrec
