// A mesh loses the vertices that it can do without, by collapse of edges.
#pragma once

#include "refine/edited_mesh.h"
#include "refine/refine.h"

#include <cstdint>
#include <vector>

namespace tetrec {

struct Collapsed {
  uint64_t empty = 0, flat = 0;  // vertices that are gone: no ray loses light around the empty ones
};

// Moves vertices onto one of their neighbours each, those whose loss the pictures show least first.
// Nothing changes elsewhere, unlike by a new triangulation, which changes tets wherever vertices
// have moved since the last one.
// The squared error that the pictures gain is estimated from the light that rays lose in the tets
// around the vertex, from what is at the centroids of these tets then, and from what went around
// the vertex before. Vertices go until the estimates add up to options.flat_error times
// scores.squared_error.
// Vertices stay where `stays` (V) is not 0, where a tet would become flatter than those around the
// vertex, and where clear space would become opaque.
// Needs scores.visible_of_tets, a field with a row per vertex, and a mesh that has not been
// changed.
Collapsed CollapseSpare(EditedMesh& mesh, std::vector<uint8_t> stays, const FieldState& state,
                        const RefineScores& scores, const RefineOptions& options);

}  // namespace tetrec
