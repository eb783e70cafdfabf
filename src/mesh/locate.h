// Search for the tet that contains a point.
#pragma once

#include "mesh/tet_mesh.h"

namespace tetrec {

// The tet that contains `point` (either one if it is on a shared face), or kNoTet outside the mesh.
// Walks from `start` from tet to tet, through a face that separates the tet from the point. A walk
// that reaches the boundary proves that the point is outside if the boundary `is_convex`.
// Otherwise, and after a walk much longer than a mesh is wide (it may circle unless the mesh is
// Delaunay), all tets are tried (5 ns each).
uint32_t FindTet(const TetMesh& mesh, const glm::dvec3& point, uint32_t start = 0,
                 bool is_convex = false);

glm::dvec3 Centroid(const TetMesh& mesh, const glm::uvec4& tet);

// The weights of the tet's vertices whose mean is the point (barycentric coordinates), which add up
// to 1 and of which none is negative: outside of the tet, those of a point in its surface.
glm::dvec4 WeightsInTet(const TetMesh& mesh, uint32_t tet, const glm::dvec3& point);

}  // namespace tetrec
