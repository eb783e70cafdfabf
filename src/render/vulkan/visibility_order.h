// The order in which the tets of a mesh are seen from a point: keys for a sort, or ranks.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <vector>

namespace tetrec {

struct InnerFace {
  uint32_t tet;
  int face;  // of the tet
  uint32_t neighbor;
};

// Circumspheres in a frame around the centre of the mesh. From an eye e in that frame the tets of a
// Delaunay mesh are seen in the order of power - 2 center.e, and tets on one sphere in the order of
// RankTies.
struct PowerOrder {
  glm::dvec3 origin{0.0};           // of the frame [world]
  std::vector<glm::dvec4> spheres;  // (T) centre | power of the origin: |c|^2 - r^2
  // Faces whose tets are on one sphere up to rounding; they share the sphere of one of them.
  std::vector<InnerFace> tied_faces;
  uint64_t bad_faces = 0;  // not Delaunay by more than rounding; unless 0, the order is invalid
};

PowerOrder MeasurePowerOrder(const TetMesh& mesh);

// If two tets share a face, the one with the lower rank is in front; ranks may be equal.
struct VisibilityRanks {
  std::vector<uint32_t> ranks;  // (T) 0 is in front
  uint64_t tets_in_cycles = 0;  // ranked before a tet that covers them, nearest first
};

// Ranks among tets on one sphere; 0 for all others, and no ranks at all if no tets tie.
VisibilityRanks RankTies(const TetMesh& mesh, const PowerOrder& order, const glm::vec3& eye);

// Topological order of the relation "in front across a shared face" (Williams 1992, "Visibility
// ordering meshed polyhedra"); correct for every convex mesh if the relation has no cycle. The eye
// is that of the renderer, in floats.
VisibilityRanks RankByVisibility(const TetMesh& mesh, const glm::vec3& eye);

}  // namespace tetrec
