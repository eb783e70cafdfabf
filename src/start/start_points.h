// The vertices of the first mesh.
//
// Every start fills an axis-aligned box: its 8 corners are vertices and all others lie strictly
// inside, so the hull consists of 12 triangles. A slab test then finds where a ray enters, and the
// hull stays convex whatever happens inside.
#pragma once

#include "geometry/bounds3.h"
#include "geometry/occupancy_grid.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace tetrec {

enum class VertexKind : uint8_t {
  kCorner,   // a corner of the box
  kFar,      // on the shell that represents everything far away
  kOuter,    // in free or unknown space
  kNear,     // in an empty cell beside the carved surface
  kSurface,  // in a carved surface cell, or a sparse point
  kInner,    // inside the subject or its bounds
};

constexpr uint32_t kNoPoint = 0xFFFFFFFFu;

struct StartPoints {
  std::vector<glm::vec3> positions;  // (N) [world units]; the box's 8 corners come first
  std::vector<VertexKind> kinds;     // (N)
  std::vector<uint32_t> point;       // (N) index of the sparse point, or kNoPoint
};

// Start from a carved subject: a jittered vertex in each surface cell and in shares of the empty
// cells beside them (26-neighbours) and of the inner cells, random outer points and the corners of
// the box. The box is the bounding box of the inside cells, enlarged.
struct CarveStartOptions {
  double near_share = 0.5;   // share of the empty cells beside the surface
  double inner_share = 0.3;  // share of the inside cells without an empty face neighbour
  int outer_points = 400;
  double box_growth = 1.15;  // side of the box over the side of the carved cells
};
// Throws DataError if no cell is inside.
StartPoints StartFromCarve(const OccupancyGrid& grid, const CarveStartOptions& options,
                           uint64_t seed);

// Start from a jittered grid of roughly cubic cells in the box, `cells` along its longest side.
StartPoints StartFromGrid(const Bounds3& box, int cells, uint64_t seed);

struct SparsePoint {
  glm::dvec3 position{0.0};  // [world units]
  float reprojection_error_px = 0;
  uint32_t track_length = 0;  // views that see it
};

struct PointFilter {
  double max_reprojection_error_px = 2.0;
  uint32_t min_track_length = 3;  // two-view points are mostly noise
  double min_spacing = 0.002;     // [world units]
};

// Each dropped point is counted once, under the first rule that drops it.
struct FilteredPoints {
  std::vector<uint32_t> kept;  // indices, ascending
  uint64_t not_finite = 0, high_error = 0, short_track = 0, too_close = 0;
};

// Keeps the one with the longest track among points closer than min_spacing.
FilteredPoints FilterPoints(std::span<const SparsePoint> points, const PointFilter& filter);

// Start from photos: the sparse points and a fill whose spacing grows with the distance from the
// subject. The fill consists of jittered cells inside the subject's bounding sphere and Fibonacci
// spheres of geometrically growing radius, which grows faster where hardly any point is; the last
// of them is the far shell.
struct PointStartOptions {
  int sphere_points = 400;  // on each intermediate sphere; the far shell has twice as many
  double far_share = 0.98;  // share of the points that the dense part of the fill encloses
  // Limits of that part's radius over the farthest camera's distance.
  double min_fill_over_camera = 1.6, max_fill_over_camera = 8.0;
  // The shell's radius over that distance; farther points are dropped. The shell shows the sky,
  // which must hardly shift from photo to photo. Much farther away, floats would be too coarse.
  double far_over_camera = 20;
  double box_over_shell = 1.1;  // half the box's side over the radius of the shell
};
struct PointStart {
  StartPoints points;
  double far_radius = 0;     // [world units]
  uint64_t dropped_far = 0;  // sparse points beyond the shell
  uint64_t fill = 0;         // vertices that are neither sparse points nor corners
};
// `positions` must be finite; StartPoints::point indexes them. Throws DataError if there is no
// camera or the subject's bounds are empty.
PointStart StartFromPoints(std::span<const glm::dvec3> positions,
                           std::span<const glm::dvec3> cameras_in_world, const Bounds3& subject,
                           const PointStartOptions& options, uint64_t seed);

}  // namespace tetrec
