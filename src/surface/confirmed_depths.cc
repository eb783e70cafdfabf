// Depths that photos confirm, in place of those at which a field's rays are stopped.
#include "surface/confirmed_depths.h"

#include "surface/depth_between.h"

#include <glm/glm.hpp>

#include <array>
#include <limits>

namespace tetrec {
namespace {

constexpr double kMargin = 0.01;  // of the depth

// kNoDepth where the four pixels of the map around the place do not confirm one surface.
double ConfirmedDepth(const StereoDepth& map, const glm::dvec2& pixel_of_map) {
  const glm::dvec2 place = pixel_of_map - 0.5, corner = glm::floor(place), part = place - corner;
  const bool is_inside = corner.x >= 0 && corner.y >= 0 && corner.x + 1 < map.camera.width &&
                         corner.y + 1 < map.camera.height;
  if (!is_inside) return double(kNoDepth);
  std::array<double, 4> depths;
  for (int i = 0; i < 4; ++i) {
    const size_t pixel = map.Index(int(corner.x) + i % 2, int(corner.y) + i / 2);
    if (map.agreement[pixel] < kLeastAgreement) return double(kNoDepth);
    depths[size_t(i)] = double(map.depth[pixel]);
  }
  return DepthBetween(depths, part, kJumpOfDepths_px * depths[0] / map.camera.fx)
      .value_or(double(kNoDepth));
}

}  // namespace

size_t UseConfirmedDepths(const Camera& camera, const StereoDepth& map, const LossOfLight& loss,
                          DepthMap& stopped) {
  size_t replaced = 0;
  for (int y = 0; y < stopped.height; ++y) {
    for (int x = 0; x < stopped.width; ++x) {
      const float first = loss.first.At(x, y), last = loss.last.At(x, y);
      if (first == kNoDepth) continue;
      const double depth =
          ConfirmedDepth(map, map.camera.ImageFromCam(camera.CamFromImage(glm::dvec2(x, y) + 0.5)));
      const double farthest =
          last == kNoDepth ? std::numeric_limits<double>::infinity() : double(last);
      if (depth < (1 - kMargin) * double(first) || depth > (1 + kMargin) * farthest) continue;
      stopped.At(x, y) = float(depth);
      ++replaced;
    }
  }
  return replaced;
}

}  // namespace tetrec
