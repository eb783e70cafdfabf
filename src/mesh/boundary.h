// The boundary of a mesh: its faces and vertices, a check for convexity, a tree of boxes over them.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

struct BoundaryFace {
  uint32_t tet, face;  // face of that tet, 0 to 3
};

// All boundary faces, in the order of their tets.
std::vector<BoundaryFace> BoundaryFaces(const TetMesh& mesh);

// (V) 1 for vertices of boundary faces, 0 for all others.
std::vector<uint8_t> BoundaryVertices(const TetMesh& mesh);

// Explains why the boundary (all of it, as `faces`) does not enclose a convex solid, by exact
// predicates. Empty if it does.
std::string WhyNotConvex(const TetMesh& mesh, std::span<const BoundaryFace> faces);

// A box around faces. In an inner node, `first` is the axis that separates its children; the first
// child has the smaller coordinates. In a leaf, `first` and `second` are its faces, equal if it has
// only one.
struct BoxNode {
  glm::vec3 min{0.0f};
  uint32_t first = 0;
  glm::vec3 max{0.0f};
  uint32_t second = 0;
};

// A complete binary tree: the root is node 1, the children of node i are 2 i and 2 i + 1, the last
// `leaves` nodes are leaves. A traversal needs no stack: the next node follows from a node's number
// and one bit per level (Binder and Keller 2016, "Efficient stackless hierarchy traversal on GPUs
// with backtracking in constant time").
struct BoxTree {
  std::vector<BoxNode> nodes;  // node 0 is unused
  uint32_t leaves = 0;         // a power of two
};

// Sorts `faces` into the order of the leaves. Boxes exceed their faces by a few roundings of the
// coordinates, so that a ray that hits a face also hits its box when tested in float.
BoxTree BuildBoxTree(const TetMesh& mesh, std::vector<BoundaryFace>& faces);

}  // namespace tetrec
