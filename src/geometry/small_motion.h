// Small motions of cameras: six numbers, and how far they move a picture.
#pragma once

#include "geometry/camera.h"
#include "geometry/rigid3.h"

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {

// The motion that turns about `rotation` by its length [rad] and then moves by `translation`.
inline Rigid3 MotionOf(const glm::dvec3& rotation, const glm::dvec3& translation) {
  const double angle = glm::length(rotation);
  if (angle == 0) return {glm::dmat3(1.0), translation};
  return {glm::mat3_cast(glm::angleAxis(angle, rotation / angle)), translation};
}

// The rotation's axis times its angle in [0, pi] [rad].
inline glm::dvec3 RotationVector(const glm::dmat3& rotation) {
  glm::dquat q = glm::quat_cast(rotation);
  if (q.w < 0) q = -q;
  const glm::dvec3 axis(q.x, q.y, q.z);
  const double sine = glm::length(axis);
  return sine < 1e-12 ? 2.0 * axis : 2 * std::atan2(sine, q.w) / sine * axis;
}

// A camera's motion in its own frame as six numbers, turns about x, y and z and moves along them,
// each measured by how far [px] it moves the picture of things at one depth.
using MotionPx = std::array<double, 6>;

// Radians and world units per pixel of picture motion.
struct MotionUnits {
  glm::dvec3 rotation{0.0}, translation{0.0};
};

// For a depth above 0 [world units]. Turns about z and moves along it leave the centre in place;
// they are measured half of the shorter side away from it.
inline MotionUnits MotionUnitsOf(const Camera& camera, double depth) {
  const double focal = 0.5 * (camera.fx + camera.fy);
  const double radius = 0.5 * std::min(camera.width, camera.height);
  return {{1 / focal, 1 / focal, 1 / radius}, {depth / focal, depth / focal, depth / radius}};
}

inline Rigid3 MotionOf(const MotionPx& px, const MotionUnits& units) {
  return MotionOf(units.rotation * glm::dvec3(px[0], px[1], px[2]),
                  units.translation * glm::dvec3(px[3], px[4], px[5]));
}

inline MotionPx MotionPxOf(const Rigid3& motion, const MotionUnits& units) {
  const glm::dvec3 turn = RotationVector(motion.rotation) / units.rotation;
  const glm::dvec3 move = motion.translation / units.translation;
  return {turn.x, turn.y, turn.z, move.x, move.y, move.z};
}

// How far a camera's motion in its own frame moves the picture of things at `depth`: root mean
// square over the picture [px]. Infinite if some of them end up behind the camera.
inline double PictureShift(const Camera& camera, const Rigid3& motion, double depth) {
  constexpr int kSide = 8;
  double squares = 0;
  for (int i = 0; i < kSide * kSide; ++i) {
    const glm::dvec2 pixel((i % kSide + 0.5) / kSide * camera.width,
                           (i / kSide + 0.5) / kSide * camera.height);
    const glm::dvec3 moved = motion * (depth * camera.CamFromImage(pixel));
    if (!(moved.z > 0)) return INFINITY;
    const glm::dvec2 shift = camera.ImageFromCam(moved) - pixel;
    squares += glm::dot(shift, shift);
  }
  return std::sqrt(squares / (kSide * kSide));
}

}  // namespace tetrec
