// Where the subject is: what the cameras look at from all sides, as opposed to what is behind it.
#pragma once

#include "geometry/bounds3.h"
#include "scene/scene.h"

#include <span>
#include <vector>

namespace tetrec {

// Fewer points than this are too few to separate the subject from what is behind it.
inline constexpr size_t kFewPoints = 50;

struct Subject {
  glm::dvec3 focus_in_input{0.0};  // the point that the cameras look at
  glm::dvec3 up_in_input{0.0};     // unit
  // From a world in which z is up, the subject's longest side is 2 and its centre is 0.
  Similarity3 input_from_world;
  Bounds3 bounds_in_world;
  size_t points = 0;   // number of points that the box was computed from
  size_t outside = 0;  // of these, beyond the box: thin tails and outliers
};

// The point nearest to all optical axes in the sense of least squares, with outliers weighted down.
// If the axes are nearly parallel, the depth of the points that the cameras see decides.
glm::dvec3 FindFocus(const Scene& scene);

// The upright direction for hand-held cameras with upright images: perpendicular to their x axes,
// which people keep level; if these do not determine it, the mean of the cameras' own up
// directions. Cameras that look in one direction and turn about it are taken to look straight down.
glm::dvec3 FindUp(std::span<const View> views);

// `scene` is in the input's frame, with cameras, views and points. The subject is what most cameras
// see, or everything close to them if they survey it: if they look in one direction from places far
// apart. Throws DataError without points.
Subject FindSubject(const Scene& scene);

// Moves views and points into the subject's world and sets the scene's bounds.
void MoveToSubject(Scene& scene, const Subject& subject);

// Makes a box in the scene's world its bounds, and moves the world so that the box's longest side
// is 2 and its centre 0.
void MoveToBox(Scene& scene, const Bounds3& box_in_world);

// Throws UsageError unless a box that was given as bounds has a volume and finite corners.
void CheckGivenBounds(const Bounds3& bounds);

}  // namespace tetrec
