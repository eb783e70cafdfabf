// Depth maps and images that show them.
#include "image/depth_map.h"

#include "core/error.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <optional>

namespace tetrec {
namespace {

constexpr uint8_t kGrey = 96;

void PaintGrey(Image& image, int x, int y) { std::fill_n(image.At(x, y), 3, kGrey); }

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

}  // namespace

DepthMap MakeDepthMap(int width, int height) {
  return {width, height, std::vector<float>(size_t(width) * size_t(height), kNoDepth)};
}

DepthRange RangeOf(const DepthMap& map) {
  std::vector<float> depths;
  std::copy_if(map.depth.begin(), map.depth.end(), std::back_inserter(depths),
               [](float depth) { return depth != kNoDepth; });
  if (depths.empty()) return {};
  const auto at = [&](double share) {
    const auto place = depths.begin() + std::lround(share * double(depths.size() - 1));
    std::nth_element(depths.begin(), place, depths.end());
    return *place;
  };
  const float near = at(0.02);
  return {near, at(0.98)};
}

Image ColoredDepth(const DepthMap& map, const DepthRange& range) {
  Image levels = MakeImage(map.width, map.height, 3), image = levels;
  const double far = 1 / std::max(double(range.far), 1e-30),
               near = 1 / std::max(double(range.near), 1e-30);
  cv::Mat grey(map.height, map.width, CV_8UC1);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const double inverse = map.At(x, y) == kNoDepth ? far : 1 / double(map.At(x, y));
      const double share = near > far ? (inverse - far) / (near - far) : 1;
      grey.at<uint8_t>(y, x) = uint8_t(std::lround(255 * std::clamp(share, 0.0, 1.0)));
    }
  }
  cv::Mat colors;
  cv::applyColorMap(grey, colors, cv::COLORMAP_INFERNO);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const cv::Vec3b& bgr = colors.at<cv::Vec3b>(y, x);
      for (int c = 0; c < 3; ++c) image.At(x, y)[c] = bgr[2 - c];
      if (map.At(x, y) == kNoDepth) PaintGrey(image, x, y);
    }
  }
  return image;
}

Image NormalPicture(const DepthMap& map, const Camera& camera) {
  Image image = MakeImage(map.width, map.height, 3);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      PaintGrey(image, x, y);
      if (map.At(x, y) == kNoDepth) continue;
      const auto right = Tangent(map, camera, x, y, 1, 0), down = Tangent(map, camera, x, y, 0, 1);
      if (!right || !down) continue;
      const glm::dvec3 across = glm::cross(*down, *right);  // towards the camera
      const double length = glm::length(across);
      if (!(length > 0)) continue;
      const glm::dvec3 shown = glm::dvec3(across.x, -across.y, -across.z) / length;
      for (int c = 0; c < 3; ++c) {
        image.At(x, y)[c] = uint8_t(std::lround(255 * std::clamp(0.5 * (shown[c] + 1), 0.0, 1.0)));
      }
    }
  }
  return image;
}

}  // namespace tetrec
