// SSIM and error maps.
#include "eval/image_metrics.h"

#include "image/psnr.h"

#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

namespace tetrec {
namespace {

cv::Mat Channel(const Image& image, int channel) {
  cv::Mat values(image.height, image.width, CV_64F);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      values.at<double>(y, x) = image.At(x, y)[channel] / 255.0;
    }
  }
  return values;
}

cv::Mat WindowMean(const cv::Mat& values) {
  static const cv::Mat kWindow = cv::getGaussianKernel(11, 1.5, CV_64F);
  cv::Mat mean;
  cv::sepFilter2D(values, mean, CV_64F, kWindow, kWindow, {-1, -1}, 0, cv::BORDER_CONSTANT);
  return mean;
}

cv::Mat SsimOfChannel(const cv::Mat& x, const cv::Mat& y) {
  constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
  const cv::Mat mean_x = WindowMean(x), mean_y = WindowMean(y);
  const cv::Mat mean_xx = WindowMean(x.mul(x)), mean_yy = WindowMean(y.mul(y)),
                mean_xy = WindowMean(x.mul(y));
  cv::Mat ssim(x.rows, x.cols, CV_64F);
  for (int row = 0; row < x.rows; ++row) {
    for (int col = 0; col < x.cols; ++col) {
      const double mx = mean_x.at<double>(row, col), my = mean_y.at<double>(row, col);
      const double var_x = mean_xx.at<double>(row, col) - mx * mx;
      const double var_y = mean_yy.at<double>(row, col) - my * my;
      const double covariance = mean_xy.at<double>(row, col) - mx * my;
      // SSIM = (2 mx my + C1)(2 cov + C2) / ((mx^2 + my^2 + C1)(var_x + var_y + C2))
      ssim.at<double>(row, col) = (2 * mx * my + kC1) * (2 * covariance + kC2) /
                                  ((mx * mx + my * my + kC1) * (var_x + var_y + kC2));
    }
  }
  return ssim;
}

bool IsHidden(const Image& mask, int x, int y) { return mask.At(x, y)[0] < kSelectedByMask; }

std::array<std::array<uint8_t, 3>, 256> InfernoTable() {
  cv::Mat ramp(1, 256, CV_8U), colors;
  for (int i = 0; i < 256; ++i) ramp.at<uint8_t>(0, i) = uint8_t(i);
  cv::applyColorMap(ramp, colors, cv::COLORMAP_INFERNO);
  std::array<std::array<uint8_t, 3>, 256> table;
  for (int i = 0; i < 256; ++i) {
    const cv::Vec3b bgr = colors.at<cv::Vec3b>(0, i);
    table[i] = {bgr[2], bgr[1], bgr[0]};
  }
  return table;
}

}  // namespace

double Ssim(const Image& render, const Image& truth) {
  CheckSameSize(render, truth, "ground truth");
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const cv::Mat ssim = SsimOfChannel(Channel(render, c), Channel(truth, c));
    double of_channel = 0;
    for (auto value = ssim.begin<double>(); value != ssim.end<double>(); ++value) {
      of_channel += *value;
    }
    sum += of_channel / double(ssim.total());
  }
  return sum / 3;
}

std::optional<double> MaskedSsim(const Image& render, const Image& truth, const Image& mask) {
  CheckSameSize(render, truth, "ground truth");
  const Image painted = PaintedOver(render, truth, mask);
  double sum = 0;
  size_t count = 0;
  for (int c = 0; c < 3; ++c) {
    const cv::Mat ssim = SsimOfChannel(Channel(painted, c), Channel(truth, c));
    for (int y = 0; y < render.height; ++y) {
      for (int x = 0; x < render.width; ++x) {
        if (IsHidden(mask, x, y)) continue;
        sum += ssim.at<double>(y, x);
        ++count;
      }
    }
  }
  if (count == 0) return std::nullopt;
  return sum / double(count);
}

Image PaintedOver(const Image& image, const Image& other, const Image& mask) {
  CheckSameSize(image, other, "ground truth");
  CheckSameSize(image, mask, "mask");
  Image painted = image;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (IsHidden(mask, x, y)) std::copy_n(other.At(x, y), 3, painted.At(x, y));
    }
  }
  return painted;
}

double Contrast(const Image& rgb, const Image* mask) {
  double sum = 0, squares = 0, pixels = 0;
  for (int y = 0; y < rgb.height; ++y) {
    for (int x = 0; x < rgb.width; ++x) {
      if (mask && IsHidden(*mask, x, y)) continue;
      ++pixels;
      const uint8_t* p = rgb.At(x, y);
      const double brightness = (double(p[0]) + p[1] + p[2]) / 3;
      sum += brightness;
      squares += brightness * brightness;
    }
  }
  if (pixels == 0) return 0;
  return std::sqrt(std::max(0.0, squares / pixels - sum / pixels * (sum / pixels)));
}

Image ErrorMap(const Image& render, const Image& truth) {
  CheckSameSize(render, truth, "ground truth");
  const auto table = InfernoTable();
  Image map{render.width, render.height, 3, {}};
  map.pixels.reserve(size_t(map.width) * map.height * 3);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      int sum = 0;
      for (int c = 0; c < 3; ++c) sum += std::abs(render.At(x, y)[c] - truth.At(x, y)[c]);
      const int level = std::min(255, int(std::lround(kErrorMapGain * sum / 3.0)));
      map.pixels.insert(map.pixels.end(), table[level].begin(), table[level].end());
    }
  }
  return map;
}

Image ErrorMapColorBar(int width, int height) {
  const auto table = InfernoTable();
  Image bar{width, height, 3, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const auto& color = table[x * 255 / std::max(1, width - 1)];
      bar.pixels.insert(bar.pixels.end(), color.begin(), color.end());
    }
  }
  return bar;
}

}  // namespace tetrec
