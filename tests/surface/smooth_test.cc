#include "surface/smooth.h"

#include "core/random.h"
#include "mesh/mesh_facts.h"
#include "surface/shapes.h"
#include "surface/vertex_normals.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// A shape's level set, with ripples along its normals.
TriangleMesh Rippled(const std::function<double(const glm::dvec3&)>& shape, double height) {
  const TetMesh mesh = JitteredBox(16);
  TriangleMesh surface = AsTriangles(MarchTetrahedra(mesh, Sampled(mesh, shape), 0));
  const std::vector<glm::dvec3> normals = SmoothNormals(surface, 0);
  MersenneRandom random(3);
  for (size_t v = 0; v < normals.size(); ++v) {
    surface.positions[v] += glm::vec3(height * (2 * random.Uniform() - 1) * normals[v]);
  }
  return surface;
}

// Mean over the area.
double AngleToBall(const TriangleMesh& mesh) {
  double sum = 0, areas = 0;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 normal = DoubleAreaNormal(mesh, t);
    const glm::dvec3 out =
        glm::normalize(glm::dvec3(mesh.positions[t.x]) + glm::dvec3(mesh.positions[t.y]) +
                       glm::dvec3(mesh.positions[t.z]));
    const double area = glm::length(normal);
    if (!(area > 0)) continue;
    sum += area * std::acos(std::clamp(glm::dot(normal, out) / area, -1.0, 1.0)) * 180 / M_PI;
    areas += area;
  }
  return sum / areas;
}

TEST(SmoothByNormals, RipplesOfABallGoAndItsVolumeStays) {
  const TriangleMesh rough = Rippled(Ball, 0.01);
  const TriangleMesh smooth = SmoothByNormals(rough, {.max_move = 0.02});
  EXPECT_GT(AngleToBall(rough), 6);
  EXPECT_LT(AngleToBall(smooth), 0.6 * AngleToBall(rough));
  const MeshFacts before = MeasureMesh(rough), after = MeasureMesh(smooth);
  EXPECT_NEAR(after.volume / before.volume, 1, 0.005);
  EXPECT_TRUE(after.watertight);
}

TEST(SmoothByNormals, EdgesOfACubeStaySharp) {
  const auto cube = [](const glm::dvec3& p) {
    return 0.9 - std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
  };
  const TriangleMesh rough = Rippled(cube, 0.005);
  const TriangleMesh smooth = SmoothByNormals(rough, {.max_move = 0.1});
  // The points that are nearest to the cube's edges do not retreat from them.
  for (const TriangleMesh* mesh : {&rough, &smooth}) {
    glm::vec3 high(0);
    for (const glm::vec3& p : mesh->positions) high = glm::max(high, p);
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(high[k], 0.9, 0.02);
  }
  const auto reach = [](const TriangleMesh& mesh) {
    float farthest = 0;
    for (const glm::vec3& p : mesh.positions) farthest = std::max(farthest, p.x + p.y);
    return farthest;
  };
  EXPECT_NEAR(reach(smooth), reach(rough), 0.03);
}

TEST(SmoothByNormals, NoVertexMovesFartherThanAllowedAndBordersStay) {
  TriangleMesh bowl = Rippled(Ball, 0.03);
  std::erase_if(bowl.triangles, [&](const glm::uvec3& t) { return bowl.positions[t.x].z > 0.2f; });
  const TriangleMesh smooth = SmoothByNormals(bowl, {.max_move = 0.01});
  EXPECT_EQ(MeasureMesh(smooth).boundary_edges, MeasureMesh(bowl).boundary_edges);
  size_t moved = 0;
  for (size_t v = 0; v < bowl.positions.size(); ++v) {
    const float distance = glm::distance(bowl.positions[v], smooth.positions[v]);
    EXPECT_LE(distance, 0.0101f);
    moved += distance > 0;
    if (bowl.positions[v].z > 0.35f) {
      EXPECT_EQ(distance, 0);  // not part of the bowl
    }
  }
  EXPECT_GT(moved, bowl.positions.size() / 3);

  TriangleMesh lone;
  lone.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f}};
  lone.triangles = {{0, 1, 2}};
  EXPECT_EQ(SmoothByNormals(lone, {.max_move = 1}).positions, lone.positions);
  EXPECT_EQ(SmoothByNormals(bowl, {.rounds = 0, .max_move = 1}).positions, bowl.positions);
}

}  // namespace
}  // namespace tetrec
