// Bad start meshes are still meshes, and as bad as they claim to be.
#include "stability/mesh_damage.h"

#include "core/error.h"
#include "expect_error.h"
#include "mesh/delaunay.h"
#include "mesh/locate.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetrec {
namespace {

constexpr double kHalfSide = 1;

// A jittered grid in the box [-1, 1]^3 with a density that is linear in position.
RadianceField LinearBox(int cells) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < 8; ++i) {
    points.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
  }
  for (int z = 0; z < cells; ++z) {
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        const float jitter = 0.01f * float((7 * x + 3 * y + 5 * z) % 11);
        points.push_back(glm::vec3(x, y, z) * (1.8f / float(cells)) - 0.85f + jitter);
      }
    }
  }
  RadianceField field{BuildDelaunay(points).mesh, {}, {}};
  for (const glm::vec3& p : field.mesh.positions) {
    field.density.push_back(2 + p.x);
    field.color_srgb.push_back(0.5f + 0.2f * p);
  }
  return field;
}

double LargestVolume(const TetMesh& mesh) {
  double largest = 0;
  for (const glm::uvec4& tet : mesh.tets) largest = std::max(largest, TetVolume(mesh, tet));
  return largest;
}

TEST(MeshDamage, AddsSliversAndKeepsTheField) {
  RadianceField field = LinearBox(6);
  const size_t vertices = field.mesh.positions.size();
  AddSlivers(field, {glm::dvec3(-0.9), glm::dvec3(0.9)}, 100);
  CheckTetMesh(field.mesh);
  CheckConvexDomain(field.mesh);
  CheckField(field);
  ASSERT_EQ(field.mesh.positions.size(), vertices + 100);
  const auto is_sliver = [&](const glm::uvec4& tet) { return RadiusRatio(field.mesh, tet) < 1e-3; };
  EXPECT_GE(std::ranges::count_if(field.mesh.tets, is_sliver), 100);
  for (size_t v = vertices; v < field.mesh.positions.size(); ++v) {
    EXPECT_NEAR(field.density[v], 2 + field.mesh.positions[v].x, 1e-5) << v;
  }
}

TEST(MeshDamage, RefusesMoreSliversThanThereAreTets) {
  RadianceField field = LinearBox(2);
  EXPECT_THROW(AddSlivers(field, {glm::dvec3(-0.5), glm::dvec3(0.5)}, 100'000), DataError);
}

TEST(MeshDamage, PutsOneHugeTetInTheMiddle) {
  RadianceField field = LinearBox(9);
  ReplaceMiddleByOneTet(field, {glm::dvec3(-kHalfSide), glm::dvec3(kHalfSide)});
  CheckTetMesh(field.mesh);
  CheckConvexDomain(field.mesh);
  CheckField(field);
  // A regular tet in a ball of 0.99 x 0.8 has 8 / (9 sqrt(3)) x radius^3 = 0.255.
  EXPECT_NEAR(LargestVolume(field.mesh), 0.255, 0.003);
}

TEST(MeshDamage, RefusesAnEmptyMiddle) {
  RadianceField field = LinearBox(2);
  EXPECT_THROW(ReplaceMiddleByOneTet(field, {glm::dvec3(-0.01), glm::dvec3(0.01)}), DataError);
}

}  // namespace
}  // namespace tetrec
