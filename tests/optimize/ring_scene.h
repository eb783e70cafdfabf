// Cameras around a ball of sparse points.
#pragma once

#include "scene/scene.h"

#include <cmath>
#include <numbers>

namespace tetrec {

// The radius of the circle on which the cameras stand. The points are on the unit sphere.
inline constexpr double kRing = 3.0;

inline glm::dvec3 OnRing(double turns) {
  const double angle = 2 * std::numbers::pi * turns;
  return kRing * glm::dvec3(std::cos(angle), std::sin(angle), 0.0);
}

inline Scene RingOfCameras(int cameras, int points) {
  Scene scene;
  scene.cameras = {{64, 64, 64, 64, 32, 32}};
  for (int i = 0; i < cameras; ++i) {
    View view;
    view.cam_from_world.translation = -OnRing(double(i) / cameras);
    scene.views.push_back(view);
  }
  for (int i = 0; i < points; ++i) {
    const double z = 1 - (2 * i + 1.0) / points, angle = 2.4 * i;
    ScenePoint point;
    point.position = {std::sqrt(1 - z * z) * std::cos(angle),
                      std::sqrt(1 - z * z) * std::sin(angle), z};
    scene.points.push_back(point);
  }
  return scene;
}

}  // namespace tetrec
