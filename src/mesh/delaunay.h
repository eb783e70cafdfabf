// Delaunay tetrahedralization, the only header that leads to CGAL.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <span>
#include <vector>

namespace tetrec {

struct DelaunayResult {
  TetMesh mesh;                           // Morton-sorted, passes CheckTetMesh
  std::vector<uint32_t> point_of_vertex;  // (V) index of the input point; duplicates are dropped
};

// Uses exact predicates, so the result is correct for every finite input. Throws DataError if a
// point is not finite, there are fewer than 4 points or all are coplanar.
DelaunayResult BuildDelaunay(std::span<const glm::vec3> points);

}  // namespace tetrec
