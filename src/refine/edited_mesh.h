// A mesh that is changed in place: edges are halved or collapsed, and the tets around them follow.
#pragma once

#include "refine/refine.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Ids of vertices and tets stay while the mesh is edited; new ones get the next ids. Each call
// takes time in proportion to the tets around the vertices that it names.
class EditedMesh {
 public:
  explicit EditedMesh(TetMesh mesh);

  // How many ids there are, including those of removed vertices and tets.
  size_t vertices() const { return mesh_.positions.size(); }
  size_t tets() const { return mesh_.tets.size(); }
  size_t vertices_left() const { return vertices() - gone_vertices_; }

  std::span<const glm::vec3> positions() const { return mesh_.positions; }
  const glm::vec3& position(uint32_t vertex) const { return mesh_.positions[vertex]; }
  const glm::uvec4& tet(uint32_t tet) const { return mesh_.tets[tet]; }
  std::span<const uint32_t> TetsAt(uint32_t vertex) const { return tets_at_[vertex]; }
  std::vector<uint32_t> TetsAround(uint32_t a, uint32_t b) const;  // around an edge

  // Where the middle of an edge is in float. Coordinates that both ends share stay exactly.
  glm::vec3 Middle(uint32_t a, uint32_t b) const;
  // A new vertex there, whose id is the number of vertices before.
  uint32_t AddMiddle(uint32_t a, uint32_t b);
  // Replaces a tet by its parts, which leaves the piecewise linear field as it is. The first part
  // takes the tet's id, the others get the next ones.
  void Cut(uint32_t tet, std::span<const glm::uvec4> parts);
  // Adds a vertex in the middle of an edge and cuts the tets around it (TetsAround) in two, unless
  // a part would not be positively oriented (exact predicate): then nothing is changed, and it
  // returns false.
  bool Halve(uint32_t a, uint32_t b, std::span<const uint32_t> around);
  // Moves the first end of an edge onto the second: the tets around the edge vanish, and in the
  // other tets at `gone`, `onto` takes its place. The caller makes sure that all tets of the mesh
  // are positively oriented before and after, and that `gone` is not on the boundary. The mesh then
  // fills the same solid: the cones from `onto` over the faces around `gone` have the volume of the
  // star that they replace, and do not overlap.
  void Collapse(uint32_t gone, uint32_t onto);

  // Ends the changes.
  Refinement Take();

 private:
  bool HasTet(uint32_t tet) const { return mesh_.tets[tet][0] != kNoTet; }
  void AddToVertices(uint32_t tet);
  MeshOrder Compact();

  TetMesh mesh_;  // without neighbours; a tet that is gone has no vertices (kNoTet)
  std::vector<std::vector<uint32_t>> tets_at_;
  std::vector<RowSource> inserted_;
  std::vector<uint32_t> old_tets_;
  size_t gone_vertices_ = 0;
};

bool Contains(const glm::uvec4& tet, uint32_t vertex);

glm::uvec4 WithVertexReplaced(glm::uvec4 tet, uint32_t gone, uint32_t onto);

// Returns true if four points are positively oriented, by the exact predicate.
bool IsPositive(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d);

}  // namespace tetrec
