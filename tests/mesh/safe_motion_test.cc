#include "mesh/safe_motion.h"

#include "geometry/orientation.h"
#include "mesh/delaunay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace tetrec {
namespace {

// Random points in the unit box, and its corners.
TetMesh RandomBox(int points, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> inside(0.01f, 0.99f);
  std::vector<glm::vec3> positions;
  for (int corner = 0; corner < 8; ++corner) {
    positions.emplace_back(corner & 1, corner >> 1 & 1, corner >> 2);
  }
  for (int i = 0; i < points; ++i) {
    positions.emplace_back(inside(random), inside(random), inside(random));
  }
  return BuildDelaunay(positions).mesh;
}

bool IsInside(const glm::vec3& position) {
  return glm::all(glm::greaterThan(position, glm::vec3(0.0f))) &&
         glm::all(glm::lessThan(position, glm::vec3(1.0f)));
}

// Moves the mesh.
MotionCounts Move(TetMesh& mesh, std::span<const glm::vec3> moves) {
  SafeMotion motion = MoveSafely(mesh, moves);
  mesh.positions = std::move(motion.positions);
  return motion.counts;
}

// By `move(v)` wherever a vertex is not on the boundary.
template <class MoveOf>
std::vector<glm::vec3> MovesInside(const TetMesh& mesh, const MoveOf& move) {
  std::vector<glm::vec3> moves(mesh.positions.size(), glm::vec3(0.0f));
  for (size_t v = 0; v < moves.size(); ++v) {
    if (IsInside(mesh.positions[v])) moves[v] = move(v);
  }
  return moves;
}

size_t InvertedTets(const TetMesh& mesh) {
  size_t inverted = 0;
  for (const glm::uvec4& tet : mesh.tets) {
    inverted += size_t(Orientation(mesh.positions[tet[0]], mesh.positions[tet[1]],
                                   mesh.positions[tet[2]], mesh.positions[tet[3]]) != 1);
  }
  return inverted;
}

glm::vec3 RandomVector(std::mt19937& random, float size) {
  std::normal_distribution<float> normal(0.0f, size);
  return {normal(random), normal(random), normal(random)};
}

TEST(SafeMotion, VerticesMoveAsTheyShouldWhereNoTetSuffers) {
  TetMesh mesh = RandomBox(200, 1);
  // Tets of this mesh have inradii above 1e-6.
  ASSERT_GT(MeasureQuality(mesh).min_volume, 1e-10);
  const std::vector<glm::vec3> before = mesh.positions;
  std::mt19937 random(2);
  const auto moves = MovesInside(mesh, [&](size_t) { return RandomVector(random, 1e-7f); });
  const MotionCounts counts = Move(mesh, moves);
  EXPECT_EQ(counts.shortened + counts.stopped, 0u);
  EXPECT_EQ(counts.moved, 200u);
  for (size_t v = 0; v < before.size(); ++v) EXPECT_EQ(mesh.positions[v], before[v] + moves[v]);
}

TEST(SafeMotion, ATetKeepsItsShareOfVolume) {
  TetMesh mesh = RandomBox(300, 3);
  const TetMesh before = mesh;
  std::mt19937 random(4);
  const MotionCounts counts =
      Move(mesh, MovesInside(mesh, [&](size_t) { return RandomVector(random, 0.03f); }));
  EXPECT_GT(counts.moved, 0u);
  EXPECT_GT(counts.shortened, 0u);
  EXPECT_GT(counts.stopped, 0u);
  EXPECT_EQ(counts.all(), 300u);
  for (const glm::uvec4& tet : mesh.tets) {
    EXPECT_GE(TetVolume(mesh, tet), (1 - 1e-9) * kKeptVolumeShare * TetVolume(before, tet));
  }
}

// The bound by the inradius would stop them all.
TEST(SafeMotion, FlatTetsFollowVerticesThatMoveTogether) {
  TetMesh mesh = RandomBox(200, 5);
  for (glm::vec3& position : mesh.positions) position.z *= 1e-4f;
  ASSERT_EQ(InvertedTets(mesh), 0u);
  const MotionCounts counts =
      Move(mesh, MovesInside(mesh, [](size_t) { return glm::vec3(1e-3f, 0.0f, 0.0f); }));
  EXPECT_GT(counts.moved, 150u);
  EXPECT_EQ(InvertedTets(mesh), 0u);
}

TEST(SafeMotion, NoTetTurnsInsideOutInManyMovesOfAnySize) {
  TetMesh mesh = RandomBox(12, 6);
  const std::vector<glm::vec3> start = mesh.positions;
  std::mt19937 random(7);
  for (int step = 0; step < 100'000; ++step) {
    const float size = std::exp2(float(int(random() % 24) - 18));
    // Everything towards one point, away from it, or anywhere.
    const int kind = step / 1000 % 3;
    const glm::vec3 goal(0.3f, 0.6f, 0.4f);
    Move(mesh, MovesInside(mesh, [&](size_t v) {
           if (kind == 2) return RandomVector(random, size);
           return (kind == 0 ? size : -size) * (goal - mesh.positions[v]);
         }));
    if (step % 500 != 0) continue;
    ASSERT_EQ(InvertedTets(mesh), 0u) << step;
  }
  EXPECT_EQ(InvertedTets(mesh), 0u);
  for (size_t v = 0; v < start.size(); ++v) {
    EXPECT_EQ(mesh.positions[v] == start[v], !IsInside(start[v])) << v;
  }
  CheckConvexDomain(mesh);
}

TEST(SafeMotion, WhatIsNoNumberMovesNothing) {
  TetMesh mesh = RandomBox(50, 8);
  const std::vector<glm::vec3> before = mesh.positions;
  for (const float bad :
       {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e38f}) {
    const MotionCounts counts =
        Move(mesh, MovesInside(mesh, [&](size_t) { return glm::vec3(bad); }));
    EXPECT_EQ(counts.stopped, 50u);
    EXPECT_EQ(mesh.positions, before);
  }
}

}  // namespace
}  // namespace tetrec
