// Normals from depths.
#include "image/normal_map.h"

#include <cmath>
#include <optional>

namespace tetrec {
namespace {

glm::dvec3 PointAt(const DepthMap& map, const Camera& camera, int x, int y) {
  return double(map.At(x, y)) * camera.CamFromImage({x + 0.5, y + 0.5});
}

// The difference of points along one axis of the image, from the neighbour of which the depth
// differs less; nothing if neither neighbour shows a surface.
std::optional<glm::dvec3> Tangent(const DepthMap& map, const Camera& camera, int x, int y, int dx,
                                  int dy) {
  std::optional<glm::dvec3> best;
  for (const int side : {1, -1}) {
    const int nx = x + side * dx, ny = y + side * dy;
    if (nx < 0 || ny < 0 || nx >= map.width || ny >= map.height) continue;
    if (map.At(nx, ny) == kNoDepth) continue;
    const glm::dvec3 step =
        double(side) * (PointAt(map, camera, nx, ny) - PointAt(map, camera, x, y));
    if (!best || std::abs(step.z) < std::abs(best->z)) best = step;
  }
  return best;
}

glm::dvec3 NormalAt(const DepthMap& map, const Camera& camera, int x, int y) {
  if (map.At(x, y) == kNoDepth) return glm::dvec3(0.0);
  const auto right = Tangent(map, camera, x, y, 1, 0), down = Tangent(map, camera, x, y, 0, 1);
  if (!right || !down) return glm::dvec3(0.0);
  const glm::dvec3 across = glm::cross(*down, *right);  // towards the camera
  const double length = glm::length(across);
  return length > 0 ? across / length : glm::dvec3(0.0);
}

}  // namespace

NormalMap MakeNormalMap(int width, int height) {
  return {width, height, std::vector<glm::vec3>(size_t(width) * size_t(height), glm::vec3(0.0f))};
}

NormalMap NormalsOf(const DepthMap& map, const Camera& camera) {
  NormalMap normals = MakeNormalMap(map.width, map.height);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) normals.At(x, y) = NormalAt(map, camera, x, y);
  }
  return normals;
}

NormalMap Rotated(const glm::dmat3& rotation, NormalMap map) {
  for (glm::vec3& normal : map.normal) normal = glm::vec3(rotation * glm::dvec3(normal));
  return map;
}

}  // namespace tetrec
