// Which way is up, as the photos show it.
#pragma once

#include "scene/scene.h"

namespace tetrec {

// The mean direction from the bottom to the top of the images, of unit length; z if the cameras are
// turned in all directions and have no common up.
inline glm::dvec3 UpInWorld(const Scene& scene) {
  glm::dvec3 up(0.0);
  for (const View& view : scene.views) {
    up += glm::transpose(view.cam_from_world.rotation) * glm::dvec3(0, -1, 0);
  }
  const double length = glm::length(up);
  return length > 0.05 * double(scene.views.size()) ? up / length : glm::dvec3(0, 0, 1);
}

}  // namespace tetrec
