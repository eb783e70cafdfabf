// Evaluates a run: scores its images and its surface against the ground truth and writes a report.
#pragma once

#include "core/stage.h"

#include <vector>

namespace tetrec {

struct EvaluateOptions {
  double threshold_percent = 1;     // [% of the subject's diagonal] distance that counts as found
  size_t surface_samples = 200000;  // points on each surface
  uint64_t seed = 1;
  // xmin ymin zmin xmax ymax zmax [units of the ground truth]; empty: the bounding box of the
  // ground truth, grown as SurfaceScoreOptions::bounds says.
  std::vector<double> ground_truth_bounds;

  void Check() const;  // throws UsageError naming the option and its value
};

// Inputs of the stage: "VIEWS" (of render), optionally "SURFACE" (of surface), "ground-truth" (a
// mesh), "cameras" (in the frame of that mesh) and "depth-maps" (of a NeRF-synthetic data set).
// Writes metrics.json and report.html. The PSNR of
// identical images is infinite: it is null in JSON, and "identical_views" counts them.
void Evaluate(const EvaluateOptions& options, Stage& stage);

}  // namespace tetrec
