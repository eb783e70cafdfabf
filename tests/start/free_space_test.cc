#include "start/free_space.h"

#include "mesh/delaunay.h"
#include "start/start_points.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace tetrec {
namespace {

// A jittered grid in a box, a sheet of points at z = 0, and a camera above.
struct Sheet {
  TetMesh mesh;
  std::vector<SightLine> lines;
};

Sheet MakeSheet(const std::vector<glm::dvec3>& cameras) {
  std::vector<glm::vec3> points = StartFromGrid({glm::dvec3(-1), glm::dvec3(1)}, 8, 1).positions;
  std::erase_if(points, [](const glm::vec3& p) { return std::abs(p.z) < 0.15f; });
  Sheet sheet;
  for (int y = 0; y < 14; ++y) {
    for (int x = 0; x < 14; ++x) {
      const glm::dvec3 p(0.13 * (x - 6.5) + 0.003 * y, 0.13 * (y - 6.5), 1e-3 * ((x * 7 + y) % 5));
      points.emplace_back(p);
      for (const glm::dvec3& camera : cameras) sheet.lines.push_back({p, camera, 0.13, 0});
    }
  }
  sheet.mesh = BuildDelaunay(points).mesh;
  return sheet;
}

glm::dvec3 CenterOf(const TetMesh& mesh, size_t tet) {
  glm::dvec3 center(0.0);
  for (int i = 0; i < 4; ++i) center += 0.25 * glm::dvec3(mesh.positions[mesh.tets[tet][i]]);
  return center;
}

void ExpectFreeAboveAndFullBelow(const Sheet& sheet) {
  const FreeSpace space = LabelFreeSpace(sheet.mesh, sheet.lines);
  EXPECT_LT(space.lost_lines, sheet.lines.size() / 50);
  size_t above = 0, free_above = 0, below = 0, full_below = 0;
  for (size_t t = 0; t < sheet.mesh.tets.size(); ++t) {
    const glm::dvec3 center = CenterOf(sheet.mesh, t);
    if (std::max(std::abs(center.x), std::abs(center.y)) > 0.6) continue;
    if (center.z > 0.1) {
      ++above;
      free_above += space.is_full[t] ? 0 : 1;
    } else if (center.z < -0.02 && center.z > -0.1) {
      ++below;
      full_below += space.is_full[t];
    }
  }
  ASSERT_GT(above, 100u);
  ASSERT_GT(below, 20u);
  EXPECT_EQ(free_above, above);
  EXPECT_GT(double(full_below), 0.95 * double(below));
}

TEST(LabelFreeSpace, IsFreeBetweenASheetAndItsCamerasAndFullBehind) {
  ExpectFreeAboveAndFullBelow(MakeSheet({{0, 0, 0.9}, {0.3, 0.2, 0.8}}));
}

TEST(LabelFreeSpace, SeesThroughTheHullFromOutside) {
  ExpectFreeAboveAndFullBelow(MakeSheet({{0, 0, 5}, {1, 0, 4}}));
}

TEST(LabelFreeSpace, OutvotesOneMistakenPoint) {
  Sheet sheet = MakeSheet({{0, 0, 5}, {1, 0, 4}, {-1, 0.5, 5}});
  sheet.lines.push_back({{0.05, 0.05, 0.5}, {0, 0, 5}, 0.13, 0});
  ExpectFreeAboveAndFullBelow(sheet);
}

TEST(LabelFreeSpace, LeavesTetsUncrossedThatNoLinePasses) {
  const Sheet sheet = MakeSheet({{0, 0, 5}});
  const FreeSpace space = LabelFreeSpace(sheet.mesh, sheet.lines);
  for (size_t t = 0; t < sheet.mesh.tets.size(); ++t) {
    if (CenterOf(sheet.mesh, t).z < -0.3) {
      EXPECT_EQ(space.crossings[t], 0u);
    }
  }
}

}  // namespace
}  // namespace tetrec
