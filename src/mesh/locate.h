// Which tet holds a point.
#pragma once

#include "mesh/tet_mesh.h"

namespace tetrec {

// The tet that holds `point` (on a shared face: either), or kNoTet outside the mesh. Walks from tet
// to tet through the face that the point lies beyond, from `start`. Where the walk ends at the
// boundary the point is outside a mesh whose boundary `is_convex`; of others all tets are tried
// then (5 ns each).
uint32_t FindTet(const TetMesh& mesh, const glm::dvec3& point, uint32_t start = 0,
                 bool is_convex = false);

}  // namespace tetrec
