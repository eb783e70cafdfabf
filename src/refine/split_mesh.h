// A mesh that grows: edges are halved, and the tets around them are cut.
#pragma once

#include "refine/refine.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// Cuts leave the piecewise linear field as it is, because each part lies inside the tet that it
// comes from. Each call takes time in proportion to the tets around the vertices that it names.
class SplitMesh {
 public:
  explicit SplitMesh(TetMesh mesh);

  size_t vertices() const { return mesh_.positions.size(); }
  size_t tets() const { return mesh_.tets.size(); }
  const glm::vec3& position(uint32_t vertex) const { return mesh_.positions[vertex]; }
  const glm::uvec4& tet(uint32_t tet) const { return mesh_.tets[tet]; }
  std::span<const uint32_t> TetsAt(uint32_t vertex) const { return tets_at_[vertex]; }

  // Where the middle of an edge is in float. Coordinates that both ends share stay exactly.
  glm::vec3 Middle(uint32_t a, uint32_t b) const;
  // A new vertex there, whose id is the number of vertices before.
  uint32_t AddMiddle(uint32_t a, uint32_t b);
  // The first part takes the tet's id, the others get the next ones.
  void Cut(uint32_t tet, std::span<const glm::uvec4> parts);

  // Ends the growth.
  Refinement Take();

 private:
  void AddToVertices(uint32_t tet);

  TetMesh mesh_;  // without neighbours
  std::vector<std::vector<uint32_t>> tets_at_;
  std::vector<RowSource> inserted_;
  std::vector<uint32_t> old_tets_;
};

// Returns true if four points are positively oriented, by the exact predicate.
bool IsPositive(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d);

}  // namespace tetrec
