#include "start/initial_field.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

// A row of tets: tet k has the vertices k .. k + 3 of a helix, so that vertex 0 is far from the
// last.
TetMesh Row(int tets) {
  TetMesh mesh;
  for (int v = 0; v < tets + 3; ++v) {
    mesh.positions.emplace_back(std::cos(2.3f * float(v)), std::sin(2.3f * float(v)),
                                0.6f * float(v));
  }
  for (uint32_t t = 0; t < uint32_t(tets); ++t) mesh.tets.emplace_back(t, t + 1, t + 2, t + 3);
  mesh.neighbors = ComputeNeighbors(mesh.tets, mesh.positions.size());
  return mesh;
}

TEST(MakeSubjectField, IsThinnestOutside) {
  const std::vector<VertexKind> kinds = {VertexKind::kSurface, VertexKind::kInner,
                                         VertexKind::kNear, VertexKind::kOuter};
  const RadianceField field = MakeSubjectField(Row(1), kinds, {});
  EXPECT_EQ(field.density[0], field.density[1]);
  EXPECT_GT(field.density[1], 5 * field.density[2]);
  EXPECT_GT(field.density[2], 2 * field.density[3]);
  EXPECT_GT(field.density[3], 0) << "a vanishing density would get no gradient";
}

TEST(MakePhotoField, HasTheSameOpticalDepthAtEveryScale) {
  const std::vector<VertexKind> kinds(8, VertexKind::kOuter);
  const std::vector<std::optional<glm::vec3>> colors(8);
  TetMesh large = Row(5);
  for (glm::vec3& p : large.positions) p *= 64.0f;
  const RadianceField a = MakePhotoField(Row(5), kinds, colors, {}),
                      b = MakePhotoField(large, kinds, colors, {});
  for (size_t v = 0; v < 8; ++v) EXPECT_FLOAT_EQ(a.density[v], 64 * b.density[v]);
}

TEST(MakePhotoField, SpreadsColoursFromTheSparsePoints) {
  const std::vector<VertexKind> kinds(13, VertexKind::kOuter);
  std::vector<std::optional<glm::vec3>> colors(13);
  colors.front() = glm::vec3(1, 0, 0);
  colors.back() = glm::vec3(0, 0, 1);
  const RadianceField field = MakePhotoField(Row(10), kinds, colors, {});
  EXPECT_EQ(field.color_srgb[0], glm::vec3(1, 0, 0));
  EXPECT_EQ(field.color_srgb[3], glm::vec3(1, 0, 0));
  EXPECT_EQ(field.color_srgb[10], glm::vec3(0, 0, 1));
  for (const glm::vec3& c : field.color_srgb)
    EXPECT_NEAR(c.r + c.g + c.b, 1, 1e-6);  // means of means
  EXPECT_GT(field.density[0], field.density[4]) << "sparse points are denser than the fill";
}

TEST(MakePhotoField, IsGreyWithoutSparsePoints) {
  const std::vector<VertexKind> kinds(5, VertexKind::kOuter);
  const std::vector<std::optional<glm::vec3>> colors(5);
  for (const glm::vec3& c : MakePhotoField(Row(2), kinds, colors, {}).color_srgb) {
    EXPECT_EQ(c, glm::vec3(0.5f));
  }
}

}  // namespace
}  // namespace tetrec
