// Refinement by bisection of longest edges.
#pragma once

#include "refine/refine.h"

namespace tetrec {

// Bisects the tets with the largest scores, as far as the budget goes. A tet is bisected at the
// middle of its longest edge together with all tets around that edge, after those among them whose
// own longest edge is longer (Rivara, "New longest-edge algorithms for the refinement and/or
// improvement of unstructured triangulations", 1997). The mesh stays conforming, and its tets about
// as good as they were. The piecewise linear field stays exactly as it is, and so does a field with
// a row per tet.
// Edges of the boundary whose rounded middle is not exactly on it are passed over: the longest of
// the other edges counts. A tet stays, and is counted as refused, if its edge is shorter than
// min_edge or a part would not be positively oriented (exact predicate).
Refinement BisectTets(TetMesh mesh, const RefineScores& scores, const RefineOptions& options);

}  // namespace tetrec
