// Normal maps: for each pixel which way the first surface faces, and their files.
#pragma once

#include "geometry/camera.h"
#include "image/depth_map.h"

#include <glm/glm.hpp>

#include <filesystem>
#include <vector>

namespace tetrec {

struct NormalMap {
  int width = 0, height = 0;
  std::vector<glm::vec3> normal;  // (height x width) unit vectors, or 0 where there is no surface

  glm::vec3& At(int x, int y) { return normal[size_t(y) * size_t(width) + size_t(x)]; }
  const glm::vec3& At(int x, int y) const { return normal[size_t(y) * size_t(width) + size_t(x)]; }
};

// Without any surface.
NormalMap MakeNormalMap(int width, int height);

// From neighbouring depths, in the camera frame, towards the camera. The neighbour of which the
// depth differs less is used on each axis, so that edges stay sharp.
NormalMap NormalsOf(const DepthMap& map, const Camera& camera);

NormalMap Rotated(const glm::dmat3& rotation, NormalMap map);

// OpenEXR files whose channels R, G and B are x, y and z, as floats. Reading throws like ReadImage,
// also if a vector is neither 0 nor of length 1, or if there are not three channels of floats.
void WriteNormalMap(const std::filesystem::path& path, const NormalMap& map);
NormalMap ReadNormalMap(const std::filesystem::path& path);

}  // namespace tetrec
