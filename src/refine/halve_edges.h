// Refinement in place: edges are halved, and vertices that are not needed are collapsed.
#pragma once

#include "refine/refine.h"

namespace tetrec {

// First, the vertices that the mesh can do without are collapsed (collapse.h), so that the budget
// leaves room for others: if scores.visible_of_tets is known, the field has a row per vertex, and
// all tets are positively oriented. The scores of tets that vanish are lost. Then edges are halved,
// with all tets around them, as far as the budget goes: first those with the largest product of
// their length and the mean score of the tets around them. Bisection of longest edges (bisect.h)
// also cuts tets far from any error: on lego, three of four new vertices of such a round lay where
// no ray loses light.
// No tet is cut twice in a round. Edges stay if both ends are on the boundary, if an end has
// options.max_splits_at_vertex halved edges, if they are shorter than options.min_edge, or, counted
// as refused, if a part would not be positively oriented (exact predicate).
// Halved edges leave the piecewise linear field exactly as it is.
Refinement HalveEdges(TetMesh mesh, const FieldState& state, const RefineScores& scores,
                      const RefineOptions& options);

}  // namespace tetrec
