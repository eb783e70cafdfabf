// A box cuts a surface in two.
#pragma once

#include "geometry/bounds3.h"
#include "geometry/rigid3.h"
#include "mesh/triangle_mesh.h"

namespace tetrec {

struct CutSurface {
  TriangleMesh inside, outside;  // together the surface, without texture coordinates
};

// Cuts triangles along the faces of the box, so that the part inside ends flush with them. Vertices
// that are as near to a face as 1e-6 of the surface's diagonal are moved onto it, so that cuts
// leave no triangles of next to no area there. Both parts keep the order of what they have.
CutSurface CutByBox(const TriangleMesh& mesh, const Bounds3& box,
                    const Similarity3& box_from_mesh = {});

}  // namespace tetrec
