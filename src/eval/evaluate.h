// Judges a run: pictures against the truth, the surface against a true one, and the report.
#pragma once

#include "core/stage.h"

#include <vector>

namespace tetrec {

struct EvaluateOptions {
  double threshold_percent = 1;     // of the subject's diagonal: what counts as found
  size_t surface_samples = 200000;  // points on each surface
  uint64_t seed = 1;
  // xmin ymin zmin xmax ymax zmax in the ground truth's units; empty: its bounding box grown by 5
  // %.
  std::vector<double> ground_truth_bounds;

  void Check() const;  // throws UsageError naming the option and its value
};

// Inputs of the stage: "VIEWS" (of render), optionally "SURFACE" (of surface), "ground-truth"
// (mesh) and "cameras" (its cameras). Writes metrics.json and report.html. PSNR of equal pictures
// is infinite, which JSON cannot say: it is null there, and "identical_views" counts them.
void Evaluate(const EvaluateOptions& options, Stage& stage);

}  // namespace tetrec
