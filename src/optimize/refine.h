// Coarse to fine: adds vertices where the images are wrong, removes them where space is empty.
#pragma once

#include "field/field_state.h"
#include "mesh/tet_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

struct RefineOptions {
  double growth = 2.0;  // largest ratio of vertices after and before
  uint64_t max_vertices = 1000000;
  double min_edge = 1e-3;        // shorter edges are not split [world units]
  int max_splits_at_vertex = 3;  // new points per round on edges that end at one vertex
  double empty_depth = 0.02;     // optical depth over an edge below which a vertex is empty
  double drop_share = 0.5;       // of the empty vertices, per round
  uint64_t seed = 1;
};

struct RefineResult {
  TetMesh mesh;
  FieldState state;
  std::vector<RowSource> vertex_sources;  // of each vertex, among those of the old mesh
  uint64_t split_edges = 0, dropped_empty = 0;
};

// Splits the longest edge of the tets with the largest error near its middle, drops some of the
// vertices whose whole neighbourhood is empty, and triangulates again (Delaunay).
//   error  (T) the share of the images' error that each tet causes
// Attributes and Adam's moments of a new vertex are those of the linear field on its edge
// (Prolong), so the field on the old mesh is reproduced exactly; it changes only where the Delaunay
// mesh has other tets, around new vertices and where vertices have moved. The hull's vertices stay.
// If cells have the attributes, a new tet gets the row of the old tet that contains its centroid.
// Unless cells need it, the old mesh is freed before the new one takes memory.
RefineResult Refine(TetMesh mesh, const FieldState& state, std::span<const float> error,
                    const RefineOptions& options);

}  // namespace tetrec
