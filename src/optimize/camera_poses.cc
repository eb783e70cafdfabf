// The poses of the training cameras, corrected while the field is fitted.
#include "optimize/camera_poses.h"

#include "geometry/small_motion.h"
#include "render/view_pose.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// The growth of a run at its first sweep, by which the picture has partly converged, and from one
// sweep to the next: the sharper the field, the longer it takes to become clearly sharper still.
constexpr double kFirstSweep = 0.2, kGrowthBetweenSweeps = 1.22;
// Until this progress, while the judging pictures are kept from learning.
constexpr double kLastSweep = 0.7;
static_assert(kLastSweep <= ScheduleOptions().last_judging);

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

// A small similarity of the world about the origin, to first order: x + rotation x x +
// translation + growth x.
struct WorldMotion {
  glm::dvec3 rotation{0.0}, translation{0.0};
  double growth = 0;
};

WorldMotion WorldMotionOf(const Vector7& values) {
  return {{values[0], values[1], values[2]}, {values[3], values[4], values[5]}, values[6]};
}

// The motion, in its own frame, of a camera that moves with the world: its centre goes along and
// its axes turn along.
Rigid3 MotionOfCamera(const Rigid3& cam_from_world, const WorldMotion& world) {
  const glm::dvec3 center = cam_from_world.Inverse().translation;
  const glm::dmat3 turn = MotionOf(world.rotation, glm::dvec3(0.0)).rotation;
  const glm::dvec3 moved = (1 + world.growth) * (turn * center) + world.translation;
  const glm::dmat3 rotation = cam_from_world.rotation * glm::transpose(turn);
  return Rigid3{rotation, -(rotation * moved)} * cam_from_world.Inverse();
}

Vector6 CorrectionPx(const Rigid3& from, const Rigid3& to, const MotionUnits& units) {
  const MotionPx px = MotionPxOf(to * from.Inverse(), units);
  return Vector6(px.data());
}

// Derivatives of a camera's motion [px] by the seven numbers of a world's motion.
Eigen::Matrix<double, 6, 7> MotionDerivatives(const Rigid3& cam_from_world,
                                              const MotionUnits& units) {
  constexpr double kStep = 1e-6;
  Eigen::Matrix<double, 6, 7> derivatives;
  for (int i = 0; i < 7; ++i) {
    const Rigid3 motion = MotionOfCamera(cam_from_world, WorldMotionOf(kStep * Vector7::Unit(i)));
    const MotionPx px = MotionPxOf(motion, units);
    derivatives.col(i) = Vector6(px.data()) / kStep;
  }
  return derivatives;
}

// How far a camera was corrected, and how far a world's motion would move it [px].
struct CameraMotion {
  Vector6 correction;
  Eigen::Matrix<double, 6, 7> derivatives;
};

std::vector<CameraMotion> MotionsOf(std::span<const RenderView> given,
                                    std::span<const CorrectedPose> poses) {
  std::vector<CameraMotion> motions;
  for (size_t i = 0; i < poses.size(); ++i) {
    if (poses[i].depth <= 0) continue;
    const MotionUnits units = MotionUnitsOf(given[i].camera, poses[i].depth);
    motions.push_back({CorrectionPx(given[i].cam_from_world, poses[i].cam_from_world, units),
                       MotionDerivatives(given[i].cam_from_world, units)});
  }
  return motions;
}

// The world's motion that leaves the least sum of distances to the corrections of the cameras, so
// that a few cameras that were wrong do not move it (by iteratively reweighted least squares).
WorldMotion CommonMotion(std::span<const RenderView> given, std::span<const CorrectedPose> poses) {
  constexpr int kRounds = 20;
  constexpr double kAlike_px = 0.02;  // smaller differences count by their squares
  const std::vector<CameraMotion> cameras = MotionsOf(given, poses);
  Vector7 solution = Vector7::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Matrix7 normal = Matrix7::Zero();
    Vector7 right = Vector7::Zero();
    for (const CameraMotion& camera : cameras) {
      const double away_px = (camera.correction - camera.derivatives * solution).norm();
      const double weight = round == 0 ? 1 : 1 / std::max(away_px, kAlike_px);
      normal += weight * camera.derivatives.transpose() * camera.derivatives;
      right += weight * camera.derivatives.transpose() * camera.correction;
    }
    // A little on the diagonal, for cameras that leave one of the numbers open.
    normal.diagonal() += 1e-9 * normal.trace() * Vector7::Ones();
    solution = normal.ldlt().solve(right);
    if (!solution.allFinite()) return {};
  }
  return WorldMotionOf(solution);
}

}  // namespace

void RemoveCommonMotion(std::span<const RenderView> given, std::span<CorrectedPose> poses) {
  // The second round takes what the first, of first order, left.
  for (int round = 0; round < 2; ++round) {
    WorldMotion back = CommonMotion(given, poses);
    back = {-back.rotation, -back.translation, -back.growth};
    for (CorrectedPose& pose : poses) {
      pose.cam_from_world = MotionOfCamera(pose.cam_from_world, back) * pose.cam_from_world;
    }
  }
}

PoseEstimate::PoseEstimate(std::span<const RenderView> given) {
  // Two cameras have next to nothing but a common motion.
  if (given.size() < 3) return;
  for (const RenderView& view : given) state_.poses.push_back({view.cam_from_world});
}

bool PoseEstimate::IsDue(const RunMoment& moment) const {
  return is_on() && moment.progress < kLastSweep &&
         moment.growth >= kFirstSweep * std::pow(kGrowthBetweenSweeps, state_.sweeps);
}

size_t PoseEstimate::Sweep(Renderer& renderer, const PoseTargets& targets, uint64_t seed,
                           int pixels) {
  size_t changed = 0;
  for (size_t i = 0; i < state_.poses.size(); ++i) {
    CorrectedPose& pose = state_.poses[i];
    const PoseTask task{{targets.given[i].camera, pose.cam_from_world},
                        targets.given[i].cam_from_world,
                        targets.targets[i],
                        targets.exposures.empty() ? ViewExposure{} : targets.exposures[i],
                        targets.background_srgb};
    const uint64_t view_seed = seed ^ (uint64_t{state_.sweeps + 1} << 40) ^ (uint64_t{i} << 8);
    const PoseFit fit = FitPose(renderer, task, {.pixels = pixels, .seed = view_seed});
    pose = {fit.cam_from_world, fit.depth};
    changed += fit.is_better;
  }
  RemoveCommonMotion(targets.given, state_.poses);
  ++state_.sweeps;
  return changed;
}

}  // namespace tetrec
