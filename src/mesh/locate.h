// Which tet holds a point.
#pragma once

#include "mesh/tet_mesh.h"

namespace tetrec {

// The tet that holds `point` (on a shared face: either), or kNoTet outside the mesh, whose hull is
// convex. Walks from tet to tet through the face that the point lies beyond, from `start`.
uint32_t FindTet(const TetMesh& mesh, const glm::dvec3& point, uint32_t start = 0);

}  // namespace tetrec
