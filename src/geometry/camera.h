// Pinhole cameras. The camera frame is COLMAP's: x right, y down, z forward; pixel centres are at
// +0.5.
#pragma once

#include "geometry/rigid3.h"

#include <glm/glm.hpp>

namespace tetrec {

struct Camera {
  int width = 0, height = 0;              // [px]
  double fx = 0, fy = 0, cx = 0, cy = 0;  // [px], from the image's corner

  // Pixel of a point in the camera frame with z > 0.
  glm::dvec2 ImageFromCam(const glm::dvec3& point_in_cam) const {
    return {fx * point_in_cam.x / point_in_cam.z + cx, fy * point_in_cam.y / point_in_cam.z + cy};
  }
  // True if a point in the camera frame is in front of the camera and inside the image.
  bool Shows(const glm::dvec3& point_in_cam) const {
    if (!(point_in_cam.z > 0)) return false;
    const glm::dvec2 pixel = ImageFromCam(point_in_cam);
    return pixel.x >= 0 && pixel.y >= 0 && pixel.x < width && pixel.y < height;
  }
  // Direction with z = 1 (not unit length) through a pixel position.
  glm::dvec3 CamFromImage(const glm::dvec2& pixel) const {
    return {(pixel.x - cx) / fx, (pixel.y - cy) / fy, 1.0};
  }
  // The camera whose image is this one's, resampled to another size.
  Camera Resized(int new_width, int new_height) const {
    const double x = double(new_width) / width, y = double(new_height) / height;
    return {new_width, new_height, fx * x, fy * y, cx * x, cy * y};
  }
};

}  // namespace tetrec
