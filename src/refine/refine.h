// Coarse to fine: schemes that refine a mesh, behind one interface.
//
// A scheme is a function from a mesh, scores of its tets and vertices, and a budget to a new mesh,
// and to the rule how the rows of its field come from those of the old one (Refinement). It is
// declared in a header of its own and called by Refine.
#pragma once

#include "core/words.h"
#include "field/field_state.h"
#include "mesh/tet_mesh.h"

#include <cstdint>
#include <vector>

namespace tetrec {

enum class RefineScheme {
  kInsert,  // inserts vertices and triangulates again (insert_vertices.h)
  kHalve,   // collapses spare vertices, halves the edges with the largest scores (halve_edges.h)
  kPrism,   // halves all edges at a vertex (split_prisms.h)
  kBisect,  // halves the longest edge of a tet (bisect.h)
};
template <>
inline constexpr auto kWords<RefineScheme> =
    std::to_array<Word<RefineScheme>>({{RefineScheme::kInsert, "insert"},
                                       {RefineScheme::kHalve, "halve"},
                                       {RefineScheme::kPrism, "prism"},
                                       {RefineScheme::kBisect, "bisect"}});

// Returns true for schemes that drop vertices which the images do not need. The other schemes leave
// every picture as it is.
inline bool DropsVertices(RefineScheme scheme) {
  return scheme == RefineScheme::kInsert || scheme == RefineScheme::kHalve;
}

// How the diagonals of prisms are chosen (prism.h).
enum class PrismDiagonals {
  kShorter,  // the shorter one of each quad: a total order of the vertices around the split one
  kFlips,    // the search of Erleben et al., or the shorter one where it takes too long
};
template <>
inline constexpr auto kWords<PrismDiagonals> = std::to_array<Word<PrismDiagonals>>(
    {{PrismDiagonals::kShorter, "shorter"}, {PrismDiagonals::kFlips, "flips"}});

struct RefineOptions {
  RefineScheme scheme = RefineScheme::kInsert;
  double growth = 2.0;  // largest ratio of vertices after and before
  uint64_t max_vertices = 1000000;
  double min_edge = 1e-3;  // shorter edges are not split [world units]
  // insert, halve: new points per round on edges that end at one vertex
  int max_splits_at_vertex = 3;
  double empty_depth = 0.02;  // insert: optical depth over an edge below which a vertex is empty
  double drop_share = 1.0;    // insert: of the empty vertices, per round
  // insert, halve: share of the squared error that flat vertices may cost
  double flat_error = 0.01;
  // insert: of the vertices, in a mesh that is coarsened; below 1, the least needed go until so
  // many are left, whatever that costs, instead of flat ones. With a growth of 0 none are inserted.
  double kept_share = 1.0;
  PrismDiagonals diagonals = PrismDiagonals::kShorter;
  double split_share = 1.0;  // prism: of the vertices, which are split in one round at most
  uint64_t seed = 1;
};

// How much the images ask for a finer mesh at each place: measured at tets or at vertices, or both.
// The other is empty, or the same as seen from there.
struct RefineScores {
  std::vector<float> of_tets;      // (T)
  std::vector<float> of_vertices;  // (V)
  // (T) The light that rays lose in each tet (TetScores::light), by which vertices are found
  // that the mesh can do without (spare_vertices.h, collapse.h); their squared error may grow by a
  // share of squared_error. Empty if that is not known.
  std::vector<float> visible_of_tets;
  // (V) Not 0 for vertices that must stay, whatever the images show: those that keep the space of
  // the cameras empty. Empty if there are none.
  std::vector<uint8_t> is_kept;
  double squared_error = 0.0;  // of the rays of visible_of_tets
};

// Fills the empty one: a vertex gets a quarter of the scores of its tets; a tet gets from each of
// its vertices the share that is due to one of the vertex's tets.
void CompleteScores(const TetMesh& mesh, RefineScores& scores);

// What a scheme makes of a mesh.
struct Refinement {
  TetMesh mesh;  // Morton-sorted, passes CheckTetMesh; its boundary encloses the same solid
  Prolongation of_vertices;
  // (T) For a field with a row per tet only: the old tet that contains each new tet's centroid.
  std::vector<uint32_t> old_tets;
  uint64_t split_edges = 0, dropped_empty = 0, dropped_flat = 0;
  // insert: dropped vertices that returned, and vertices added inside old tets (darkened.h).
  uint64_t put_back = 0, patches = 0;
  uint64_t refused = 0;  // splits that would have harmed the mesh
};

// (V) 1 for vertices that must stay: those of the hull, and those of scores.is_kept.
std::vector<uint8_t> FixedVertices(const TetMesh& mesh, const RefineScores& scores);

// The number of vertices that the mesh may get.
uint64_t VertexBudget(size_t vertices, const RefineOptions& options);

// Indices of scores, the largest first.
std::vector<uint32_t> WorstFirst(const std::vector<float>& scores);

struct RefineResult : Refinement {
  FieldState state;
};

// Refines a mesh and the field on it by the scheme of the options. The rows of new vertices,
// attributes and Adam's moments, are those of the linear field on the edges that they split
// (Prolong).
RefineResult Refine(TetMesh mesh, const FieldState& state, RefineScores scores,
                    const RefineOptions& options);

}  // namespace tetrec
