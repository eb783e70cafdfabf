// Coarse to fine: new vertices where the pictures are wrong, none where there is nothing.
#pragma once

#include "mesh/tet_mesh.h"
#include "render/renderer.h"

#include <cstdint>
#include <span>

namespace tetrec {

struct RefineOptions {
  double growth = 2.0;  // vertices after over before, at most
  uint64_t max_vertices = 1000000;
  double min_edge = 1e-3;        // shorter edges are not split [world units]
  int max_splits_at_vertex = 3;  // new points on edges that end at one vertex, a round
  double empty_depth = 0.02;     // optical depth over an edge below which a vertex is empty
  double drop_share = 0.5;       // of the empty vertices, a round
  uint64_t seed = 1;
};

struct RefineResult {
  TetMesh mesh;
  VertexState state;
  uint64_t split_edges = 0, dropped_empty = 0;
};

// Splits the longest edge of the tets with the largest error near its middle, drops part of the
// vertices whose whole neighbourhood is empty, and triangulates anew (Delaunay).
//   error  (T) how much of the pictures' error each tet is to blame for
// Attributes and Adam's moments of a new vertex are those of the linear field on its edge, so the
// field on the old mesh is reproduced exactly; only where Delaunay flips does it change. The hull's
// vertices stay. Where cells have the attributes, a new tet takes the row of the old tet that holds
// its centroid.
RefineResult Refine(const TetMesh& mesh, const VertexState& state, std::span<const float> error,
                    const RefineOptions& options);

}  // namespace tetrec
