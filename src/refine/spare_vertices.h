// The vertices that a mesh can do without.
#pragma once

#include "refine/refine.h"

#include <cstdint>
#include <vector>

namespace tetrec {

struct SpareVertices {
  std::vector<uint8_t> is_spare;  // (V)
  uint64_t empty = 0, flat = 0;   // their numbers
};

// Vertices of the hull and those of scores.is_kept are never spare. Of the others these are:
// Empty ones: no ray loses light in any tet around them, which are empty or hidden inside what is
// opaque. Where scores.visible_of_tets is not known, vertices without visible density around them,
// of which options.drop_share are taken by the seed.
// Flat ones: the affine fit to their neighbours gives their own values, so that the pictures change
// little without them. The squared error that the pictures gain is estimated from the deviation
// and from the light that rays lose around the vertex; the flattest are taken, no two of them
// neighbours, until the estimates add up to options.flat_error times the present squared error.
// If options.kept_share is below 1, the least needed ones instead: those of the least estimates,
// where a vertex takes over the estimates of the neighbours that go, so that what is left is
// spread. Both need scores.visible_of_tets and a field with a row per vertex.
SpareVertices FindSpareVertices(const TetMesh& mesh, const FieldState& state,
                                const RefineScores& scores, const RefineOptions& options);

}  // namespace tetrec
