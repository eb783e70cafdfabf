// The pose of one view fitted to its picture while the field stays as it is.
#include "render/view_pose.h"

#include "core/random.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

constexpr double kDifference_px = 0.5;      // to either side
constexpr double kPriorDeviation_px = 2;    // of each number of the correction
constexpr double kLongestStep_px = 2;       // beyond which a picture is not linear
constexpr double kShortestStep_px = 0.01;   // not worth a look at other pixels
constexpr double kHuberDeviations = 1.345;  // 95 % efficient for normal residuals
constexpr double kLeastDeviation = 0.01;    // finer residuals are those of 8-bit steps
// The channels of a pixel, and pixels of one thing, err together.
constexpr double kIndependentShare = 0.1;
constexpr double kStandardErrors = 2;
constexpr double kLeastGain = 0.005;  // per residual, of its variance: 0.02 to 0.04 dB
constexpr int kDepthPixels = 256;

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Every step-th pixel of a picture in both directions.
struct Lattice {
  int step = 1, first_x = 0, first_y = 0;
};

Lattice DrawLattice(const Camera& camera, int pixels, Random& random) {
  const double step = std::sqrt(double(camera.width) * camera.height / pixels);
  const int least = std::max(2, int(step));
  return {least, int(random.Below(uint32_t(least))), int(random.Below(uint32_t(least)))};
}

// The pixels in the middle between those of another lattice.
Lattice Between(const Lattice& lattice) {
  const auto moved = [&](int first) { return (first + lattice.step / 2) % lattice.step; };
  return {lattice.step, moved(lattice.first_x), moved(lattice.first_y)};
}

// A camera whose pixels' centres are those of the lattice.
Camera CameraOf(const Camera& camera, const Lattice& lattice) {
  const auto count = [&](int size, int first) {
    return std::max(1, (size - first + lattice.step - 1) / lattice.step);
  };
  const auto center = [&](double c, int first) { return (c - first - 0.5) / lattice.step + 0.5; };
  return {count(camera.width, lattice.first_x),
          count(camera.height, lattice.first_y),
          camera.fx / lattice.step,
          camera.fy / lattice.step,
          center(camera.cx, lattice.first_x),
          center(camera.cy, lattice.first_y)};
}

// The target at a pixel of the lattice.
uint32_t TargetAt(const TargetImage& target, const Lattice& lattice, int x, int y) {
  const int at_x = std::min(lattice.first_x + x * lattice.step, target.width - 1);
  const int at_y = std::min(lattice.first_y + y * lattice.step, target.height - 1);
  return target.rgba8[size_t(at_y) * target.width + at_x];
}

// What the field shows at a pixel that counts, and what it should show.
struct LatticePixel {
  glm::dvec3 color, target;
  double transmittance;
};

std::vector<LatticePixel> Look(Renderer& renderer, const PoseTask& task, const Rigid3& pose,
                               const Lattice& lattice) {
  const RenderView view{CameraOf(task.view.camera, lattice), pose};
  const RenderedImage image = renderer.Render(view, 1);
  std::vector<LatticePixel> pixels;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const uint32_t packed = TargetAt(task.target, lattice, x, y);
      if (packed == kNotJudgedTarget) continue;
      const size_t at = size_t(y) * image.width + x;
      const glm::dvec3 premultiplied =
          glm::dvec3(packed & 255, packed >> 8 & 255, packed >> 16 & 255) / 255.0;
      const double alpha = (packed >> 24) / 255.0;
      pixels.push_back({glm::dvec3(image.color_srgb[at]),
                        premultiplied + (1 - alpha) * glm::dvec3(task.background_srgb),
                        double(image.transmittance[at])});
    }
  }
  return pixels;
}

ViewExposure ExposureOf(const PoseTask& task, const std::vector<LatticePixel>& pixels) {
  if (task.exposure) return *task.exposure;
  ViewExposure exposure;
  for (int c = 0; c < 3; ++c) {
    GainOffsetSums sums;
    for (const LatticePixel& pixel : pixels) {
      sums.Add(pixel.color[c], 1 - pixel.transmittance,
               pixel.target[c] - pixel.transmittance * double(task.background_srgb[c]));
    }
    const GainOffsetPrior prior{1 + 0.01 * sums.ww, 1 + 0.01 * sums.ww};
    const GainOffset fit = FitGainOffset(sums, prior).value_or(GainOffset{});
    exposure.gain[c] = fit.gain;
    exposure.offset[c] = fit.offset;
  }
  return exposure;
}

// Three per pixel.
Eigen::VectorXd ResidualsOf(const PoseTask& task, const std::vector<LatticePixel>& pixels,
                            const ViewExposure& exposure) {
  Eigen::VectorXd residuals(Eigen::Index(3 * pixels.size()));
  for (size_t i = 0; i < pixels.size(); ++i) {
    const LatticePixel& pixel = pixels[i];
    const glm::dvec3 residual =
        exposure.gain * pixel.color + exposure.offset * (1 - pixel.transmittance) +
        pixel.transmittance * glm::dvec3(task.background_srgb) - pixel.target;
    for (int c = 0; c < 3; ++c) residuals[Eigen::Index(3 * i) + c] = residual[c];
  }
  return residuals;
}

Rigid3 Moved(const Rigid3& pose, const Vector6& step_px, const MotionUnits& units) {
  MotionPx px;
  for (int i = 0; i < 6; ++i) px[size_t(i)] = step_px[i];
  return MotionOf(px, units) * pose;
}

Eigen::MatrixXd JacobianOf(Renderer& renderer, const PoseTask& task, const Rigid3& pose,
                           const MotionUnits& units, const Lattice& lattice,
                           const ViewExposure& exposure) {
  Eigen::MatrixXd jacobian;
  for (int i = 0; i < 6; ++i) {
    const auto residuals = [&](double px) {
      const Rigid3 moved = Moved(pose, px * Vector6::Unit(i), units);
      return ResidualsOf(task, Look(renderer, task, moved, lattice), exposure);
    };
    const Eigen::VectorXd ahead = residuals(kDifference_px);
    jacobian.resize(ahead.size(), 6);
    jacobian.col(i) = (ahead - residuals(-kDifference_px)) / (2 * kDifference_px);
  }
  return jacobian;
}

// The standard deviation of residuals by their median absolute value.
double DeviationOf(const Eigen::VectorXd& residuals) {
  std::vector<double> sizes(residuals.size());
  for (Eigen::Index i = 0; i < residuals.size(); ++i) sizes[size_t(i)] = std::abs(residuals[i]);
  const auto middle = sizes.begin() + std::ptrdiff_t(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return std::max(1.4826 * *middle, kLeastDeviation);
}

double HuberCost(double residual, double limit) {
  const double size = std::abs(residual);
  return size <= limit ? 0.5 * size * size : limit * (size - 0.5 * limit);
}

// The step that lowers Huber's cost and the pull on the whole correction, to first order.
Vector6 StepFrom(const Eigen::VectorXd& residuals, const Eigen::MatrixXd& jacobian,
                 double deviation, const Vector6& correction_px) {
  const double limit = kHuberDeviations * deviation;
  const Eigen::VectorXd weights =
      (limit / residuals.array().abs().max(limit)) * (kIndependentShare / (deviation * deviation));
  const double pull = 1 / (kPriorDeviation_px * kPriorDeviation_px);
  const Matrix6 normal =
      jacobian.transpose() * weights.asDiagonal() * jacobian + Matrix6(pull * Matrix6::Identity());
  const Vector6 gradient =
      jacobian.transpose() * weights.cwiseProduct(residuals) + pull * correction_px;
  const Vector6 step = -normal.ldlt().solve(gradient);
  if (!step.allFinite()) return Vector6::Zero();
  return step * std::min(1.0, kLongestStep_px / std::max(step.cwiseAbs().maxCoeff(), 1e-12));
}

Vector6 CorrectionOf(const PoseTask& task, const Rigid3& pose, const MotionUnits& units) {
  const MotionPx px = MotionPxOf(pose * task.given_cam_from_world.Inverse(), units);
  return Vector6(px.data());
}

double MedianDepth(Renderer& renderer, const PoseTask& task) {
  Random random(0);
  const Lattice lattice = DrawLattice(task.view.camera, kDepthPixels, random);
  const DepthMap map = renderer.RenderDepth(
      {CameraOf(task.view.camera, lattice), task.view.cam_from_world}, kHalfLightDepth);
  std::vector<float> depths;
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      if (map.At(x, y) != kNoDepth) depths.push_back(map.At(x, y));
    }
  }
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + std::ptrdiff_t(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return double(*middle);
}

// Whether the pixels of a lattice show that the cost fell: by twice its standard error, and enough
// to matter.
bool IsBetter(Renderer& renderer, const PoseTask& task, const Rigid3& pose, const Lattice& lattice,
              const ViewExposure& exposure, double deviation) {
  const auto residuals = [&](const Rigid3& p) {
    return ResidualsOf(task, Look(renderer, task, p, lattice), exposure);
  };
  const Eigen::VectorXd before = residuals(task.view.cam_from_world), after = residuals(pose);
  const double limit = kHuberDeviations * deviation;
  double sum = 0, squares = 0;
  const Eigen::Index pixels = before.size() / 3;
  for (Eigen::Index pixel = 0; pixel < pixels; ++pixel) {
    double gain = 0;
    for (Eigen::Index i = 3 * pixel; i < 3 * pixel + 3; ++i) {
      gain += HuberCost(before[i], limit) - HuberCost(after[i], limit);
    }
    sum += gain, squares += gain * gain;
  }
  const double least = kLeastGain * deviation * deviation * double(before.size());
  return pixels > 0 && sum > std::max(least, kStandardErrors * std::sqrt(squares));
}

}  // namespace

PoseFit FitPose(Renderer& renderer, const PoseTask& task, const PoseFitOptions& options) {
  PoseFit fit{task.view.cam_from_world, false, MedianDepth(renderer, task)};
  if (fit.depth <= 0) return fit;
  const MotionUnits units = MotionUnitsOf(task.view.camera, fit.depth);
  Random random(options.seed);
  const Lattice lattice = DrawLattice(task.view.camera, options.pixels, random);
  Rigid3 pose = task.view.cam_from_world;
  ViewExposure exposure;
  double deviation = 0, longest = 0;
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    const std::vector<LatticePixel> pixels = Look(renderer, task, pose, lattice);
    if (pixels.empty()) return fit;
    exposure = ExposureOf(task, pixels);
    const Eigen::VectorXd residuals = ResidualsOf(task, pixels, exposure);
    deviation = DeviationOf(residuals);
    const Vector6 step =
        StepFrom(residuals, JacobianOf(renderer, task, pose, units, lattice, exposure), deviation,
                 CorrectionOf(task, pose, units));
    const double length = step.cwiseAbs().maxCoeff();
    longest = std::max(longest, length);
    if (length < kShortestStep_px) break;
    pose = Moved(pose, step, units);
  }
  if (longest < kShortestStep_px) return fit;
  if (!IsBetter(renderer, task, pose, Between(lattice), exposure, deviation)) return fit;
  fit.cam_from_world = pose;
  fit.is_better = true;
  return fit;
}

}  // namespace tetrec
