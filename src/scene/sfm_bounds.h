// Where the subject is: what the cameras look at from all sides, told from what stands behind it.
#pragma once

#include "geometry/bounds3.h"
#include "scene/scene.h"

#include <span>
#include <vector>

namespace tetrec {

struct Subject {
  glm::dvec3 focus_in_input{0.0};  // the point that the cameras look at
  glm::dvec3 up_in_input{0.0};     // unit
  // From a world with z up, the subject's longest side 2 and its centre 0.
  Similarity3 input_from_world;
  Bounds3 bounds_in_world;
  size_t points = 0;  // that the box was made from
};

// The point nearest to all optical axes in the sense of least squares, far outliers weighted down.
// Where the axes are nearly parallel, the depth of the points that the cameras see decides.
glm::dvec3 FindFocus(const Scene& scene);

// The direction that is upright for hand-held cameras: perpendicular to their x axes, which are
// kept level; where these do not tell, the mean of their own up directions.
glm::dvec3 FindUp(std::span<const View> views);

// `scene` in the input's frame, with cameras, views and points. Throws DataError without points.
Subject FindSubject(const Scene& scene);

// Moves views and points to the subject's world and sets its bounds.
void MoveToSubject(Scene& scene, const Subject& subject);

}  // namespace tetrec
