// Moves of vertices that turn no tet inside out.
#pragma once

#include "mesh/tet_mesh.h"

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// A tet keeps at least this share of its volume in one motion.
constexpr double kKeptVolumeShare = 0.3;

// Counts of the vertices that had a move.
struct MotionCounts {
  uint64_t moved = 0;      // by their whole move
  uint64_t shortened = 0;  // by a part of it
  uint64_t stopped = 0;    // not at all

  uint64_t all() const { return moved + shortened + stopped; }
  void Add(const MotionCounts& other);
};

// Where the vertices (V) are after a motion.
struct SafeMotion {
  std::vector<glm::vec3> positions;  // [world units]
  MotionCounts counts;
};

// Moves all vertices at once, each by its move or by a part of it: the vertices of a tet that would
// lose more than 1 - kKeptVolumeShare of its volume, or turn inside out (exact predicate), go half
// as far, and after some halvings stay, until there is no such tet. So a flat tet stops vertices
// only if they move against each other; bounds by the inradii of the tets would always stop them.
//   moves  (V) [world units]; 0 for vertices of the boundary, which is to stay. A
//          move that is not finite is not made, and may stop its neighbours.
// A mesh without inverted tets stays one.
SafeMotion MoveSafely(const TetMesh& mesh, std::span<const glm::vec3> moves);

}  // namespace tetrec
