// The boundary of a mesh: its faces and vertices, whether it is convex, a tree of boxes over them.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

struct BoundaryFace {
  uint32_t tet, face;  // of the tet
};

// In the order of the tets.
std::vector<BoundaryFace> BoundaryFaces(const TetMesh& mesh);

// (V) 1 for vertices of boundary faces, else 0.
std::vector<uint8_t> BoundaryVertices(const TetMesh& mesh);

// Why the boundary (`faces`: all of it) encloses no convex solid, by exact predicates; empty where
// it does.
std::string WhyNotConvex(const TetMesh& mesh, std::span<const BoundaryFace> faces);

// A box around faces. Inner node: `first` is the axis along which its children are parted, the one
// with the smaller coordinates first. Leaf: `first` and `second` are its faces, or one twice.
struct BoxNode {
  glm::vec3 min{0.0f};
  uint32_t first = 0;
  glm::vec3 max{0.0f};
  uint32_t second = 0;
};

// A complete binary tree: the root is node 1, the children of node i are 2 i and 2 i + 1, the last
// `leaves` nodes are leaves. So a walk over it needs no stack: where to go on follows from a node's
// number and one bit a level (Binder and Keller 2016, "Efficient stackless hierarchy traversal on
// GPUs with backtracking in constant time").
struct BoxTree {
  std::vector<BoxNode> nodes;  // node 0 is none
  uint32_t leaves = 0;         // a power of two
};

// Sorts `faces` into the order of the leaves. Boxes are wider than the faces by a few roundings of
// the coordinates, so that a float test of a ray against them is on the safe side.
BoxTree BuildBoxTree(const TetMesh& mesh, std::vector<BoundaryFace>& faces);

}  // namespace tetrec
