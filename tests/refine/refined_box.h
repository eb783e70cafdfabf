// A box of random points, a field on it, and what all refinements of it must keep.
#pragma once

#include "core/random.h"
#include "mesh/delaunay.h"
#include "mesh/locate.h"
#include "mesh/tet_mesh.h"
#include "refine/refine.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace tetrec {

// The corners of the box [-1, 1]^3 and points strictly inside.
inline TetMesh JitteredBox(int cells = 7, uint64_t seed = 1) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < 8; ++i) {
    points.push_back(glm::vec3(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1));
  }
  Random random(seed);
  for (int i = 0; i < cells * cells * cells; ++i) {
    const glm::ivec3 cell(i % cells, i / cells % cells, i / (cells * cells));
    glm::vec3 point;
    for (int k = 0; k < 3; ++k) {
      point[k] = 1.9f * (float(cell[k]) + float(random.Uniform())) / float(cells) - 0.95f;
    }
    points.push_back(point);
  }
  return BuildDelaunay(points).mesh;
}

// True for vertices of the hull of a box that is not refined.
inline bool IsCorner(const glm::vec3& p) { return glm::abs(p) == glm::vec3(1.0f); }

// A regular grid of side x side x side points in the box, cut into tets.
inline TetMesh GridBox(int side) {
  std::vector<glm::vec3> points;
  for (int i = 0; i < side * side * side; ++i) {
    const glm::ivec3 at(i % side, i / side % side, i / (side * side));
    points.push_back(glm::vec3(at) * (2.0f / float(side - 1)) - 1.0f);
  }
  return BuildDelaunay(points).mesh;
}

// Random colours in [0, 1] and densities in [0.5, 5.5], with moments.
inline FieldState RandomState(const TetMesh& mesh, FieldStorage storage, uint64_t seed = 3) {
  const size_t rows = storage == FieldStorage::kCell ? mesh.tets.size() : mesh.positions.size();
  FieldState state{.layout = {.storage = storage}};
  Random random(seed);
  for (size_t row = 0; row < rows; ++row) {
    for (int c = 0; c < 3; ++c) state.parameters.push_back(float(random.Uniform()));
    state.parameters.push_back(std::log(0.5f + 5.0f * float(random.Uniform())));
    for (int c = 0; c < 4; ++c) {
      state.first_moment.push_back(float(random.Uniform()) - 0.5f);
      state.second_moment.push_back(float(random.Uniform()));
    }
  }
  return state;
}

inline RefineScores RandomScores(const TetMesh& mesh, uint64_t seed = 5) {
  RefineScores scores;
  Random random(seed);
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    scores.of_vertices.push_back(0.1f + float(random.Uniform()));
  }
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    scores.of_tets.push_back(0.1f + float(random.Uniform()));
  }
  return scores;
}

// Barycentric weights of a point in a tet.
inline glm::dvec4 WeightsIn(const TetMesh& mesh, const glm::uvec4& tet, const glm::dvec3& point) {
  glm::dvec4 weights;
  for (int i = -1; i < 4; ++i) {
    std::array<glm::dvec3, 4> p;
    for (int j = 0; j < 4; ++j) {
      p[size_t(j)] = j == i ? point : glm::dvec3(mesh.positions[tet[j]]);
    }
    const double volume = glm::dot(p[1] - p[0], glm::cross(p[2] - p[0], p[3] - p[0]));
    if (i < 0) {
      weights = glm::dvec4(1 / volume);
    } else {
      weights[i] *= volume;
    }
  }
  return weights;
}

// Colour and density at a point of the box.
inline glm::dvec4 ValueAt(const TetMesh& mesh, const FieldState& state, const glm::dvec3& point) {
  const uint32_t t = FindTet(mesh, point, 0, true);
  EXPECT_NE(t, kNoTet);
  const auto row = [&](size_t r) {
    const float* values = state.parameters.data() + 4 * r;
    return glm::dvec4(values[0], values[1], values[2], std::exp(double(values[3])));
  };
  if (state.layout.storage == FieldStorage::kCell) return row(t);
  const glm::dvec4 weights = WeightsIn(mesh, mesh.tets[t], point);
  glm::dvec4 value(0.0);
  for (int i = 0; i < 4; ++i) value += weights[i] * row(mesh.tets[t][i]);
  return value;
}

// Conforming, all tets positive, the same solid.
inline void ExpectSoundBox(const TetMesh& mesh) {
  EXPECT_NO_THROW(CheckTetMesh(mesh));
  EXPECT_NO_THROW(CheckConvexDomain(mesh));
  // A sum of some ten thousand doubles.
  EXPECT_NEAR(MeasureQuality(mesh).total_volume, 8.0, 1e-9);
}

// The field at random points is the same as before, up to the rounding of floats: of vertices by
// 6e-8, which on the shortest edges moves values by less than this, and of exp and log.
inline void ExpectSameField(const TetMesh& before, const FieldState& state_before,
                            const TetMesh& after, const FieldState& state_after) {
  Random random(11);
  for (int i = 0; i < 400; ++i) {
    glm::dvec3 point;
    for (int k = 0; k < 3; ++k) point[k] = 1.998 * random.Uniform() - 0.999;
    const glm::dvec4 was = ValueAt(before, state_before, point);
    const glm::dvec4 is = ValueAt(after, state_after, point);
    for (int c = 0; c < 4; ++c) ASSERT_NEAR(is[c], was[c], 2e-5) << "component " << c;
  }
}

// Refines random fields on regular and random boxes, vertex by vertex and cell by cell, up to three
// times their vertices. `options_of(seed)`: RefineOptions. Every result is sound, shows the same
// field and has at least twice the vertices, one more per edge that was split. Returns how many
// splits were refused.
template <class OptionsOf>
uint64_t ExpectSoundSplitsInManyRandomCases(const OptionsOf& options_of) {
  uint64_t refused = 0;
  for (uint64_t seed = 0; seed < 12; ++seed) {
    SCOPED_TRACE(seed);
    const TetMesh mesh = seed % 3 ? JitteredBox(4, seed) : GridBox(5);
    const FieldStorage storage = seed % 4 == 3 ? FieldStorage::kCell : FieldStorage::kVertex;
    const FieldState state = RandomState(mesh, storage, seed);
    RefineOptions options = options_of(seed);
    options.growth = 3.0;
    const RefineResult result = Refine(mesh, state, RandomScores(mesh, seed), options);
    EXPECT_EQ(result.mesh.positions.size(), mesh.positions.size() + result.split_edges);
    EXPECT_GE(result.mesh.positions.size(), 2 * mesh.positions.size());
    ExpectSoundBox(result.mesh);
    ExpectSameField(mesh, state, result.mesh, result.state);
    refused += result.refused;
  }
  return refused;
}

}  // namespace tetrec
