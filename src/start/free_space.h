// Which tets are free and which are behind a surface, by the rays of points to the cameras that see
// them.
//
// The minimum s-t cut of Labatut, Pons, Keriven, "Efficient multi-view reconstruction of
// large-scale scenes using interest points, Delaunay triangulation and graph cuts" (ICCV 2007),
// with the soft visibility of their later work (2009): a ray from a point to a camera costs what it
// crosses if something is labelled full in front of the point, and if what is just behind the point
// is free.
#pragma once

#include "mesh/tet_mesh.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

// A point and one camera that sees it.
struct SightLine {
  glm::dvec3 point{0.0}, camera{0.0};  // [world units]
  double softness =
      0;  // distance from the point at which a crossing counts by 1 - 1/sqrt(e) [world units]
  uint32_t tet = 0;  // any tet near the point, where the search for it starts
};

struct FreeSpace {
  std::vector<uint8_t> is_full;     // (T) 1: behind a surface, 0: free
  std::vector<uint32_t> crossings;  // (T) sight lines that pass through, in front of their points
  uint64_t lost_lines = 0;          // that could not be followed to the camera or the hull
};

// `mesh` has a convex boundary. A camera outside of it sees through the hull.
FreeSpace LabelFreeSpace(const TetMesh& mesh, std::span<const SightLine> lines);

}  // namespace tetrec
