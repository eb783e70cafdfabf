// Cameras turned about their axes by multiples of 90 degrees, as for photos that are stored on
// their side.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"

namespace tetrec {

// The camera whose image is this one's, turned clockwise.
inline Camera TurnedClockwise(Camera camera, int quarters) {
  for (int i = 0; i < quarters % 4; ++i) {
    camera = {camera.height, camera.width, camera.fy, camera.fx, camera.height - camera.cy,
              camera.cx};
  }
  return camera;
}

// From the frame of a camera to that of the turned one.
inline Rigid3 ClockwiseTurn(int quarters) {
  const Rigid3 quarter{glm::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1), glm::dvec3(0)};  // x -> y, y -> -x
  Rigid3 turn;
  for (int i = 0; i < quarters % 4; ++i) turn = quarter * turn;
  return turn;
}

}  // namespace tetrec
