// Moves of a surface's vertices, shortened where they would make it cross itself.
#pragma once

#include "mesh/triangle_mesh.h"

namespace tetrec {

// `moved` with the vertices of triangles that cross each other taken back towards where they are in
// `start`, which has the same triangles, until no two cross: half of the way at first, then all of
// it. Triangles that share an edge are not compared; where `start` crosses itself, so does the
// result.
TriangleMesh StepBackFromCrossings(const TriangleMesh& start, TriangleMesh moved);

}  // namespace tetrec
