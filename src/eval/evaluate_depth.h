// The depth's part of the evaluation: rendered depth maps against the true depth.
#pragma once

#include "core/stage.h"
#include "eval/evaluate_surface.h"
#include "image/depth_map.h"
#include "run/rendered_views.h"
#include "scene/scene.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// Errors over all pixels of all judged views whose true depth is known [world units].
struct DepthScores {
  std::string truth;    // where the true depth is from, in words
  double diagonal = 0;  // of the subject [world units]
  size_t views = 0, pixels = 0;
  size_t missing = 0;  // pixels at which the field has no surface: their error counts as infinite
  double median = 0;   // absolute error; infinite if half of the pixels miss
  double share_within_1_percent = 0;  // of the pixels, with an error up to 1 % of the diagonal
};

// Gathers the errors of one view after another, so that no more than one view's maps are in memory.
class DepthErrors {
 public:
  // Both maps are of one view. Throws DataError if their sizes differ.
  void Add(const DepthMap& rendered, const DepthMap& truth);
  // Nothing if no true depth is known.
  std::optional<DepthScores> Score(double diagonal) &&;

 private:
  std::vector<double> errors_;  // of all pixels whose true depth is known
  size_t views_ = 0, missing_ = 0;
};

// Judges the rendered depth maps by the stage's input "ground-truth" (the mesh, in the frame and
// the box by which `surface` was judged) or "depth-maps" (of NeRF-synthetic data sets). Nothing
// without either of them, without depth maps, or without the run's scene.
std::optional<DepthScores> EvaluateDepth(const RenderedViews& rendered,
                                         const std::optional<Scene>& scene,
                                         const std::optional<SurfaceResult>& surface,
                                         const Stage& stage, std::vector<std::string>& warnings);

// The object "depth" of metrics.json.
nlohmann::json DepthJson(const DepthScores& scores);

}  // namespace tetrec
