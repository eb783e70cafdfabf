// Rays that pass through walls.
#include "surface/passing_rays.h"

#include <glm/glm.hpp>

namespace tetrec {
namespace {

constexpr double kWallThickness = 0.05;  // of the depth

}  // namespace

PassingRays& PassingRays::operator+=(const PassingRays& other) {
  all += other.all;
  stopped += other.stopped;
  return *this;
}

PassingRays MendPassingRays(const Bounds3& bounds_in_world, const DepthMap& first,
                            const DepthMap& second, SeenDepth& view) {
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  view.free_until = MakeDepthMap(view.depth.width, view.depth.height);
  PassingRays passing;
  for (int y = 0; y < view.depth.height; ++y) {
    for (int x = 0; x < view.depth.width; ++x) {
      const glm::dvec3 ray_in_cam = view.camera.CamFromImage(glm::dvec2(x, y) + 0.5);
      const auto is_inside = [&](float depth) {
        return depth != kNoDepth &&
               bounds_in_world.Contains(world_from_cam * (double(depth) * ray_in_cam));
      };
      const float begins = first.At(x, y), ends = second.At(x, y);
      if (is_inside(view.depth.At(x, y)) || !is_inside(begins)) continue;
      ++passing.all;
      if (is_inside(ends) && double(ends) < (1 + kWallThickness) * double(begins)) {
        view.depth.At(x, y) = ends;
        ++passing.stopped;
      } else {
        view.free_until.At(x, y) = begins;
      }
    }
  }
  return passing;
}

}  // namespace tetrec
