// Rays that pass through walls.
#include "surface/passing_rays.h"

#include <glm/glm.hpp>

namespace tetrec {
namespace {

constexpr double kWallThickness = 0.05;  // of the depth

bool IsRightBehind(float depth, float front) {
  return depth != kNoDepth && double(depth) < (1 + kWallThickness) * double(front);
}

}  // namespace

PassingRays& PassingRays::operator+=(const PassingRays& other) {
  stopped += other.stopped;
  open += other.open;
  return *this;
}

PassingRays MendPassingRays(const Bounds3& bounds_in_world, const DepthsOfLoss& loss,
                            SeenDepth& view) {
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  view.free_until = MakeDepthMap(view.depth.width, view.depth.height);
  PassingRays passing;
  for (int y = 0; y < view.depth.height; ++y) {
    for (int x = 0; x < view.depth.width; ++x) {
      const float first = loss.first.At(x, y), second = loss.second.At(x, y),
                  level = loss.level.At(x, y);
      if (view.depth.At(x, y) != level) continue;
      const glm::dvec3 ray_in_cam = view.camera.CamFromImage(glm::dvec2(x, y) + 0.5);
      const auto is_inside = [&](float depth) {
        return depth != kNoDepth &&
               bounds_in_world.Contains(world_from_cam * (double(depth) * ray_in_cam));
      };
      const bool leaves = !is_inside(level);
      if (is_inside(second) && IsRightBehind(second, first) &&
          (leaves || !IsRightBehind(level, second))) {
        view.depth.At(x, y) = second;
        ++passing.stopped;
      } else if (leaves && is_inside(first)) {
        view.free_until.At(x, y) = first;
        ++passing.open;
      }
    }
  }
  return passing;
}

}  // namespace tetrec
