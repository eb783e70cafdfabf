// Depth maps: for each pixel how far away along the camera's z axis the first surface is. Their
// files, and images that show them.
#pragma once

#include "geometry/camera.h"
#include "image/image.h"

#include <glm/glm.hpp>

#include <cmath>
#include <filesystem>
#include <vector>

namespace tetrec {

// The depth of pixels that show no surface.
inline constexpr float kNoDepth = 0;

struct DepthMap {
  int width = 0, height = 0;
  std::vector<float> depth;  // (height x width) along z of the camera, or kNoDepth

  float& At(int x, int y) { return depth[size_t(y) * size_t(width) + size_t(x)]; }
  float At(int x, int y) const { return depth[size_t(y) * size_t(width) + size_t(x)]; }
};

// Without any surface.
DepthMap MakeDepthMap(int width, int height);

// The depth of a point at `distance` from the camera on the ray through a pixel's centre.
inline double DepthOfDistance(const Camera& camera, const glm::ivec2& pixel, double distance) {
  return distance / glm::length(camera.CamFromImage(glm::dvec2(pixel) + 0.5));
}

// OpenEXR files with one channel of floats. Reading throws like ReadImage, also if a depth is
// negative, infinite or not a number, or if there are several channels.
void WriteDepthMap(const std::filesystem::path& path, const DepthMap& map);
DepthMap ReadDepthMap(const std::filesystem::path& path);

// The range in which the pixels of a map lie: its 2nd and 98th percentiles. Both 0 if no pixel
// shows a surface.
struct DepthRange {
  float near = 0, far = 0;
};
DepthRange RangeOf(const DepthMap& map);

// RGB: near is bright, far is dark (inferno), in steps of 1 / depth, in which stereo is even;
// pixels without a surface are grey.
Image ColoredDepth(const DepthMap& map, const DepthRange& range);

// RGB: unit normals in the camera frame, from neighbouring depths, towards the camera: red to the
// right, green up, blue to the camera, each (n + 1) / 2. The neighbour of which the depth differs
// less is used on each axis, so that edges stay sharp. Pixels without a surface are grey.
Image NormalPicture(const DepthMap& map, const Camera& camera);

}  // namespace tetrec
