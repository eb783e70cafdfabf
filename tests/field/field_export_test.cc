#include "field/field_export.h"

#include "foreign_readers.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace tetrec {
namespace {

using nlohmann::json;

// A regular tet, and a flatter one on its face opposite vertex 0.
RadianceField TwoTets(FieldStorage storage) {
  RadianceField field;
  field.mesh.positions = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}, {-0.5f, -0.5f, -0.5f}};
  field.mesh.tets = {{0, 2, 1, 3}, {2, 1, 3, 4}};
  field.mesh.neighbors = ComputeNeighbors(field.mesh.tets, 5);
  field.storage = storage;
  for (size_t row = 0; row < RowCount(field); ++row) {
    field.density.push_back(0.25f * float(row) - 0.125f);
    field.color_srgb.emplace_back(0.25f * float(row), 0.5f, 1.0f);
  }
  if (storage == FieldStorage::kCell) field.density[0] = 3;
  return field;
}

template <class T>
json Rows(const std::vector<T>& vectors) {
  json rows = json::array();
  for (const T& v : vectors) {
    json row = json::array();
    for (int i = 0; i < v.length(); ++i) row.push_back(v[i]);
    rows.push_back(row);
  }
  return rows;
}

class FieldExport : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!HasMeshio()) GTEST_SKIP() << "python3-meshio is not installed (scripts/setup.sh)";
  }
  const ScratchFolder folder_;
};

TEST_F(FieldExport, MeshioReadsVtuAndGmshAsTheyWereWritten) {
  for (const FieldStorage storage : {FieldStorage::kVertex, FieldStorage::kCell}) {
    const RadianceField field = TwoTets(storage);
    CheckTetMesh(field.mesh);
    WriteVtu(folder_ / "field.vtu", field);
    WriteGmsh(folder_ / "field.msh", field);
    for (const char* name : {"field.vtu", "field.msh"}) {
      SCOPED_TRACE(std::string(name) + ", " + Name(storage));
      const json read = ReadByMeshio(folder_ / name);
      ASSERT_TRUE(read.is_object());
      EXPECT_EQ(read["points"], Rows(field.mesh.positions));
      EXPECT_EQ(read["cells"], json({{"tetra", Rows(field.mesh.tets)}}));
      const bool on_cells = storage == FieldStorage::kCell;
      const json density =
          on_cells ? read["cell_data"]["density"][0] : read["point_data"]["density"];
      const json color = on_cells ? read["cell_data"]["color"][0] : read["point_data"]["color"];
      EXPECT_EQ(density, json(field.density));
      EXPECT_EQ(color, Rows(field.color_srgb));
      const json quality = read["cell_data"]["quality"][0];
      ASSERT_EQ(quality.size(), 2u);
      EXPECT_NEAR(quality[0].get<double>(), 1, 1e-6);
      EXPECT_NEAR(quality[1].get<double>(), RadiusRatio(field.mesh, field.mesh.tets[1]), 1e-6);
      EXPECT_LT(quality[1].get<double>(), 0.7);
    }
  }
}

TEST_F(FieldExport, MeshioReadsMeditAsItWasWritten) {
  const RadianceField field = TwoTets(FieldStorage::kVertex);
  WriteMedit(folder_ / "field.mesh", field.mesh);
  const json read = ReadByMeshio(folder_ / "field.mesh");
  ASSERT_TRUE(read.is_object());
  EXPECT_EQ(read["points"], Rows(field.mesh.positions));
  EXPECT_EQ(read["cells"], json({{"tetra", Rows(field.mesh.tets)}}));
}

TEST(MovedForExport, KeepsTheOpticalDepthOfAnEdge) {
  const RadianceField field = TwoTets(FieldStorage::kVertex);
  const Similarity3 b_from_a{2.5, glm::dmat3({0, 1, 0}, {-1, 0, 0}, {0, 0, 1}), {10, 20, 30}};
  const RadianceField moved = MovedForExport(field, b_from_a, std::nullopt);
  ASSERT_EQ(moved.mesh.tets.size(), 2u);
  ASSERT_EQ(moved.mesh.positions.size(), 5u);
  // Vertices are numbered by their first use.
  EXPECT_EQ(moved.mesh.tets[0], glm::uvec4(0, 1, 2, 3));
  const auto depth = [](const RadianceField& f, uint32_t i, uint32_t k) {
    return 0.5f * (f.density[i] + f.density[k]) *
           glm::distance(f.mesh.positions[i], f.mesh.positions[k]);
  };
  EXPECT_NEAR(depth(moved, 0, 3), depth(field, 0, 3), 1e-5);
  EXPECT_EQ(moved.mesh.positions[0], glm::vec3(10 - 2.5f, 20 + 2.5f, 30 + 2.5f));
}

TEST(MovedForExport, CropsToTetsThatAreInsideTheBoxOfTheOtherFrame) {
  const Similarity3 b_from_a{1, glm::dmat3(1.0), {100, 0, 0}};
  const Bounds3 all_but_vertex_0{{98, -2, -2}, {102, 2, 0.999}}, nothing{{-2, -2, -2}, {2, 2, 2}};
  for (const FieldStorage storage : {FieldStorage::kVertex, FieldStorage::kCell}) {
    RadianceField field = TwoTets(storage);
    field.mesh.positions[3].z = 0.99f;
    const RadianceField moved = MovedForExport(field, b_from_a, all_but_vertex_0);
    ASSERT_EQ(moved.mesh.tets.size(), 1u);
    EXPECT_EQ(moved.mesh.positions.size(), 4u);
    EXPECT_EQ(moved.density.size(), RowCount(moved));
    EXPECT_EQ(moved.density.back(), field.density.back());
    EXPECT_EQ(MovedForExport(field, b_from_a, nothing).mesh.tets.size(), 0u);
  }
}

}  // namespace
}  // namespace tetrec
