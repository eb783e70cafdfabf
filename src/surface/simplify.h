// Fewer and better triangles for a manifold surface.
#pragma once

#include "mesh/triangle_mesh.h"

#include <cstdint>

namespace tetrec {

// Collapses edges by quadric error as long as, by what is known at each collapse, every vertex of
// the mesh stays within `max_deviation` of the simplified one, no triangle turns over and none
// becomes a sliver (4 : 1) that is worse than those that it replaces. Vertices keep their positions
// and colours. Methods: Garland and Heckbert, Surface Simplification Using Quadric Error Metrics,
// 1997; Klein, Liebich and Strasser, Mesh Reduction with Error Control, 1996; both by OpenMesh.
// Throws DataError if the mesh is not a manifold.
TriangleMesh Simplify(const TriangleMesh& mesh, double max_deviation);

// Collapses edges by quadric error until max_triangles are left, or more if borders and
// manifoldness would suffer. Vertices keep their positions and colours. Method: Garland and
// Heckbert 1997, by OpenMesh. Throws DataError if the mesh is not a manifold.
TriangleMesh Decimate(const TriangleMesh& mesh, uint64_t max_triangles);

}  // namespace tetrec
