// Delaunay tetrahedralization. The only door to CGAL.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace tetrec {

struct DelaunayResult {
  TetMesh mesh;                           // Morton-sorted, valid (CheckTetMesh holds)
  std::vector<uint32_t> point_of_vertex;  // (V) index of the input point; duplicates are dropped
};

// Exact predicates: right for every finite input. Points are taken as the exact values of their
// floats. Throws DataError: non-finite point, fewer than 4 points, all coplanar.
DelaunayResult BuildDelaunay(std::span<const glm::vec3> points);

}  // namespace tetrec
