// Refinement by new vertices and a new triangulation.
#pragma once

#include "refine/refine.h"

namespace tetrec {

// Splits the longest edge of the tets with the largest scores near its middle, drops vertices that
// the mesh can do without (spare_vertices.h), and triangulates again (Delaunay). The field on the
// old mesh is reproduced exactly at all vertices; it changes only where the Delaunay mesh has other
// tets, around new and dropped vertices and where vertices have moved. Where that would make the
// mesh opaque, dropped vertices return and others are added in place of edges to split
// (darkened.h), unless the field has cells. The hull's vertices stay.
// The old mesh is freed before the last triangulation takes memory, unless cells need it.
Refinement InsertVertices(TetMesh mesh, const FieldState& state, const RefineScores& scores,
                          const RefineOptions& options);

}  // namespace tetrec
