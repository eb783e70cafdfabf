// Refinement by the article's splits: all edges at a vertex are halved, its tets become small tets
// and prisms, and the prisms are cut.
#pragma once

#include "refine/refine.h"

namespace tetrec {

// The vertices with the largest scores are split one after another, each on the mesh that the ones
// before it left (Neuhauser, DiffTetVR, section 7), as far as the budget goes. The piecewise linear
// field stays exactly as it is, and so does a field with a row per tet. Takes time in proportion to
// the mesh and the prisms.
// A vertex is left as it is, and counted as refused, if one of its edges is shorter than min_edge,
// if the rounded middle of an edge of the boundary is not exactly on it, or if a part would not be
// positively oriented (exact predicates).
Refinement SplitPrisms(TetMesh mesh, const RefineScores& scores, const RefineOptions& options);

}  // namespace tetrec
