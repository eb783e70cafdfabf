// Where the pixels of a view are in another one.
#pragma once

#include "stereo/stereo_view.h"

#include <glm/glm.hpp>

namespace tetrec {

// Homogeneous image coordinates in a neighbour of the pixel (x, y) of a view at inverse depth w:
// base x (x + 0.5, y + 0.5, 1) + w shift.
struct ViewProjection {
  glm::dmat3 base;
  glm::dvec3 shift;
};

inline glm::dmat3 Intrinsics(const Camera& c) {
  return glm::dmat3(glm::dvec3(c.fx, 0, 0), glm::dvec3(0, c.fy, 0), glm::dvec3(c.cx, c.cy, 1));
}

inline ViewProjection ProjectionInto(const StereoView& view, const StereoView& neighbor) {
  const Rigid3 neighbor_from_view = neighbor.cam_from_world * view.cam_from_world.Inverse();
  const glm::dmat3 k = Intrinsics(neighbor.camera);
  return {k * neighbor_from_view.rotation * glm::inverse(Intrinsics(view.camera)),
          k * neighbor_from_view.translation};
}

}  // namespace tetrec
