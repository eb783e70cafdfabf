// Holes of a limited perimeter are closed.
#pragma once

#include "mesh/triangle_mesh.h"

#include <cstdint>

namespace tetrec {

struct FilledHoles {
  TriangleMesh mesh;
  uint64_t holes = 0, triangles = 0;  // that were closed, that were added
};

// Closes each loop of border edges whose length is `max_perimeter` at most, by the triangulation of
// least area over its vertices. Left open are loops of more than 200 vertices, those around pieces
// that are hardly larger than the hole, and those where each triangulation would double an edge of
// the mesh. Method: Barequet and Sharir, Filling Gaps in the Boundary of a Polyhedron, 1995. The
// mesh must be an oriented manifold.
FilledHoles FillSmallHoles(const TriangleMesh& mesh, double max_perimeter);

}  // namespace tetrec
