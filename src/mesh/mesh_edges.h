// The edges of a mesh, numbered.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <vector>

namespace tetrec {

struct MeshEdges {
  std::vector<glm::uvec2> ends;   // (E) vertex ids, the lower one first
  std::vector<uint32_t> of_tets;  // (T x 6) ids of each tet's edges, in the order of kTetEdges
};

MeshEdges EdgesOf(const TetMesh& mesh);

// The first of the longest edges of a tet, as its place in kTetEdges.
int LongestEdge(const TetMesh& mesh, const glm::uvec4& tet);

// (V) The mean length of each vertex's edges, each counted once for each of its tets.
std::vector<double> MeanEdgesOfVertices(const TetMesh& mesh);

}  // namespace tetrec
