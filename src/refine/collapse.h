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

// Moves each vertex that is not needed onto one of its neighbours, starting with those whose loss
// shows least. Unlike a new triangulation, which changes tets wherever vertices have moved since
// the last one, that changes nothing elsewhere. The squared error that the pictures gain is
// estimated from the light that rays lose in each tet around the vertex and from how the values at
// the tet's centroid change; a vertex also takes over the estimates of neighbours that were removed
// before it. Vertices go until the estimates add up to options.flat_error times
// scores.squared_error. (Each is estimated again only when its turn comes, so that one whose loss
// has become smaller meanwhile may miss its turn.) Vertices stay where `stays` (V) is not 0, where
// a tet would become worse than the worst one around the vertex and than 0.02
// (ParthasarathyQuality), and where the opacity of a clear place would rise by more than 0.05, by
// all collapses there together. Needs scores.visible_of_tets, a field with a row per vertex, and a
// mesh that has not been changed and all of whose tets are positively oriented.
Collapsed CollapseSpare(EditedMesh& mesh, std::vector<uint8_t> stays, const FieldState& state,
                        const RefineScores& scores, const RefineOptions& options);

}  // namespace tetrec
