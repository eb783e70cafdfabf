// Moves that would make a surface cross itself.
#include "surface/step_back.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

constexpr uint32_t kSide = 120;  // vertices
constexpr float kGap = 1;

// Two sheets of squares, one above the other. They are not flat, because triangles in one plane
// count as crossing.
TriangleMesh TwoSheets() {
  TriangleMesh mesh;
  for (uint32_t sheet = 0; sheet < 2; ++sheet) {
    const auto first = uint32_t(mesh.positions.size());
    for (uint32_t y = 0; y < kSide; ++y) {
      for (uint32_t x = 0; x < kSide; ++x) {
        const float bump = 0.1f * std::sin(1.3f * float(x * x) + 0.7f * float(y * (x + y)));
        mesh.positions.emplace_back(x, y, kGap * float(sheet) + bump);
        const uint32_t v = first + y * kSide + x;
        if (x + 1 == kSide || y + 1 == kSide) continue;
        mesh.triangles.emplace_back(v, v + 1, v + kSide + 1);
        mesh.triangles.emplace_back(v, v + kSide + 1, v + kSide);
      }
    }
  }
  return mesh;
}

uint32_t Lower(uint32_t x, uint32_t y) { return y * kSide + x; }

TEST(StepBackFromCrossings, TakesBackWhatGoesThroughAnotherPartAndNothingElse) {
  const TriangleMesh start = TwoSheets();
  TriangleMesh moved = start;
  for (uint32_t v = 0; v < kSide * kSide; ++v) moved.positions[v].x += 0.01f;
  // In opposite corners and in the middle, through the upper sheet; elsewhere not up to it.
  const uint32_t through[] = {Lower(5, 5), Lower(60, 61), Lower(112, 113)};
  for (const uint32_t v : through) moved.positions[v].z = 1.5f * kGap;
  const uint32_t below = Lower(30, 90);
  moved.positions[below].z = 0.7f * kGap;
  const TriangleMesh result = StepBackFromCrossings(start, moved);
  for (const uint32_t v : through) {
    EXPECT_GT(result.positions[v].z, start.positions[v].z) << v;
    EXPECT_LT(result.positions[v].z, 0.9f * kGap) << v;
  }
  EXPECT_EQ(result.positions[below], moved.positions[below]);
  for (uint32_t v = kSide * kSide; v < start.positions.size(); ++v) {
    EXPECT_EQ(result.positions[v],
              start.positions[v]);  // the upper sheet has nowhere to go back to
  }
  EXPECT_EQ(StepBackFromCrossings(start, moved).positions, result.positions);
}

// The boxes of the large triangle and of each small one meet in a small part of its box.
TEST(StepBackFromCrossings, FindsCrossingsAnywhereInALargeTriangle) {
  TriangleMesh start = TwoSheets();
  start.positions.resize(kSide * kSide);
  std::erase_if(start.triangles, [](const glm::uvec3& t) {
    return std::max({t.x, t.y, t.z}) >= kSide * kSide;
  });
  const auto first = uint32_t(start.positions.size());
  start.positions.insert(start.positions.end(), {{-1, -1, 1}, {250, -1, 1.1f}, {-1, 250, 1.2f}});
  start.triangles.emplace_back(first, first + 1, first + 2);
  for (const uint32_t v : {Lower(3, 3), Lower(20, 100), Lower(100, 20), Lower(64, 32)}) {
    TriangleMesh moved = start;
    moved.positions[v].z = 2;
    const TriangleMesh result = StepBackFromCrossings(start, moved);
    EXPECT_LT(result.positions[v].z, 1.2f) << v;
    moved.positions[v].z = 0.8f;
    EXPECT_EQ(StepBackFromCrossings(start, moved).positions[v], moved.positions[v]) << v;
  }
}

// A surface of a subject in front of a distant background, of which the parts differ in size as
// much as in distance.
TEST(StepBackFromCrossings, ASmallPartOfALargeSurfaceIsTakenBackAsByItself) {
  const TriangleMesh start = TwoSheets();
  TriangleMesh moved = start;
  for (uint32_t v = 0; v < kSide * kSide; v += 7) moved.positions[v].z = 1.5f * kGap;
  const auto with_background = [](TriangleMesh mesh) {
    for (float far = 1000; far < 1e6f; far *= 1.1f) {
      const auto first = uint32_t(mesh.positions.size());
      for (const glm::vec3& corner :
           {glm::vec3(1, 0, 0.5f), glm::vec3(1.2f, 0.1f, 0.5f), glm::vec3(1.1f, 0.3f, 0.6f)}) {
        mesh.positions.push_back(far * corner);
        mesh.positions.push_back(-far * corner);
      }
      mesh.triangles.emplace_back(first, first + 2, first + 4);
      mesh.triangles.emplace_back(first + 1, first + 3, first + 5);
    }
    return mesh;
  };
  const std::vector<glm::vec3> expected = StepBackFromCrossings(start, moved).positions;
  EXPECT_NE(expected, moved.positions);
  TriangleMesh result = StepBackFromCrossings(with_background(start), with_background(moved));
  result.positions.resize(expected.size());
  EXPECT_EQ(result.positions, expected);
}

TEST(StepBackFromCrossings, NothingHasNothingToTakeBack) {
  EXPECT_TRUE(StepBackFromCrossings({}, {}).positions.empty());
}

}  // namespace
}  // namespace tetrec
