// The depth map of a plane.
#pragma once

#include "geometry/camera.h"
#include "image/depth_map.h"

namespace tetrec {

inline constexpr Camera kCamera{40, 30, 50, 50, 20, 15};

// The depth of the plane n.p = d in the camera frame.
inline DepthMap PlaneDepth(const glm::dvec3& n, double d) {
  DepthMap map = MakeDepthMap(kCamera.width, kCamera.height);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      map.At(x, y) = float(d / glm::dot(n, kCamera.CamFromImage({x + 0.5, y + 0.5})));
    }
  }
  return map;
}

}  // namespace tetrec
