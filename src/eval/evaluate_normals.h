// The normals' part of the evaluation: rendered normal maps against those of a data set.
#pragma once

#include "core/stage.h"
#include "image/normal_map.h"
#include "run/rendered_views.h"
#include "scene/scene.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// Angles over all pixels of all judged views that have both a true and a rendered normal.
struct NormalScores {
  size_t views = 0, pixels = 0;
  size_t missing = 0;  // pixels with a true normal alone, which count in no angle
  double mean_angle_deg = 0, median_angle_deg = 0;
};

// Gathers the angles of one view after another, so that no more than one view's maps are in memory.
class NormalAngles {
 public:
  // Both maps are of one view. Throws DataError if their sizes differ.
  void Add(const NormalMap& rendered, const NormalMap& truth);
  // Nothing if no pixel has both.
  std::optional<NormalScores> Score() &&;

 private:
  std::vector<double> angles_deg_;  // of all pixels that have both
  size_t views_ = 0, missing_ = 0;
};

// Judges the rendered normal maps by those of the stage's input "depth-maps" (a NeRF-synthetic data
// set). Nothing without it, without normal maps on either side, or without the run's scene.
std::optional<NormalScores> EvaluateNormals(const RenderedViews& rendered,
                                            const std::optional<Scene>& scene, const Stage& stage,
                                            std::vector<std::string>& warnings);

// The object "normals" of metrics.json.
nlohmann::json NormalsJson(const NormalScores& scores);

}  // namespace tetrec
