// The cameras' part of a run: when their poses are corrected, and whether that is kept.
#include "optimize/pose_sweeps.h"

#include "core/error.h"
#include "core/log.h"
#include "core/timer.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

// What the first sweep over the cameras must gain on the judging pictures [dB].
constexpr double kLeastGainOfSweep_db = 0.03;

bool CorrectsPoses(PoseMode mode, bool were_estimated) {
  return mode == PoseMode::kAuto ? were_estimated : mode == PoseMode::kOn;
}

}  // namespace

void PoseSweeps::Start(bool were_estimated, double progress) {
  if (CorrectsPoses(options_.poses, were_estimated)) {
    poses_ = PoseEstimate(pictures_.given_views());
  }
  pictures_.PlaceCameras(state().poses, progress);
}

void PoseSweeps::Resume(PoseState state, const std::string& checkpoint, double progress) {
  const size_t cameras = pictures_.given_views().size();
  if (!state.poses.empty() && state.poses.size() != cameras) {
    throw DataError(fmt::format("{}: contains the poses of {} cameras, not {}; force a fresh run",
                                checkpoint, state.poses.size(), cameras));
  }
  poses_ = PoseEstimate(std::move(state));
  pictures_.PlaceCameras(poses_.state().poses, progress);
}

double PoseSweeps::Sweep(std::span<const ViewExposure> exposures, double progress) {
  const Timer timer;
  const bool decides = state().sweeps == 0;
  const std::vector<TargetImage> targets = pictures_.WithoutJudging();
  const size_t changed = poses_.Sweep(
      renderer_, {pictures_.given_views(), targets, exposures, pictures_.background_srgb()},
      options_.seed);
  pictures_.PlaceCameras(state().poses, progress);
  LogInfo("sweep {} over the cameras: {} of {} corrected, {:.1f} s", state().sweeps, changed,
          state().poses.size(), timer.seconds());
  if (!decides) return 0;
  return KeepIfBetter(changed > 0 ? GainOnJudging(progress) : 0, progress);
}

// What the corrections gain on the judging pictures with the field as it is [dB].
double PoseSweeps::GainOnJudging(double progress) {
  const double corrected = pictures_.JudgeField().psnr;
  pictures_.PlaceCameras({}, progress);
  const double given = pictures_.JudgeField().psnr;
  pictures_.PlaceCameras(state().poses, progress);
  return corrected - given;
}

double PoseSweeps::KeepIfBetter(double gain, double progress) {
  const bool is_better = gain >= kLeastGainOfSweep_db;
  LogInfo("the judging pictures change by {:+.2f} dB with the corrected cameras: {}", gain,
          is_better ? "they are kept" : "all stay where they were found");
  if (is_better) return gain;
  poses_.GiveUp();
  pictures_.PlaceCameras({}, progress);
  return 0;
}

}  // namespace tetrec
