// Depth maps and images that show them.
#include "image/depth_map.h"

#include "core/error.h"
#include "image/normal_map.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>

namespace tetrec {
namespace {

constexpr uint8_t kGrey = 96;

void PaintGrey(Image& image, int x, int y) { std::fill_n(image.At(x, y), 3, kGrey); }

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

Image NormalPicture(const DepthMap& depth, const Camera& camera) {
  const NormalMap map = NormalsOf(depth, camera);
  Image image = MakeImage(map.width, map.height, 3);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const glm::dvec3 normal(map.At(x, y));
      if (normal == glm::dvec3(0.0)) {
        PaintGrey(image, x, y);
        continue;
      }
      const glm::dvec3 shown(normal.x, -normal.y, -normal.z);
      for (int c = 0; c < 3; ++c) {
        image.At(x, y)[c] = uint8_t(std::lround(255 * std::clamp(0.5 * (shown[c] + 1), 0.0, 1.0)));
      }
    }
  }
  return image;
}

}  // namespace tetrec
