// The cameras' part of a run: when the poses of the training cameras are corrected, and whether the
// corrections are kept.
#pragma once

#include "optimize/camera_poses.h"
#include "optimize/optimize_options.h"
#include "optimize/training_pictures.h"
#include "render/exposure.h"
#include "render/training_renderer.h"

#include <span>
#include <string>

namespace tetrec {

class PoseSweeps {
 public:
  // Corrects nothing before Start or Resume.
  PoseSweeps(const OptimizeOptions& options, TrainingPictures& pictures, TrainingRenderer& renderer)
      : options_(options), pictures_(pictures), renderer_(renderer) {}

  // The cameras are where the scene has them. `were_estimated`: from the photos.
  void Start(bool were_estimated, double progress);
  // Throws DataError that names `checkpoint` if the state is of another number of cameras.
  void Resume(PoseState state, const std::string& checkpoint, double progress);

  bool IsDue(const RunMoment& moment) const { return poses_.IsDue(moment); }
  // Corrects the cameras by the field as it is. What the first sweep gains on the judging pictures
  // decides whether corrections are kept at all. Returns that gain if they are [dB]; 0 if not, and
  // for later sweeps.
  double Sweep(std::span<const ViewExposure> exposures, double progress);

  const PoseState& state() const { return poses_.state(); }

 private:
  double GainOnJudging(double progress);
  double KeepIfBetter(double gain, double progress);

  const OptimizeOptions& options_;
  TrainingPictures& pictures_;
  TrainingRenderer& renderer_;
  PoseEstimate poses_;
};

}  // namespace tetrec
