// The surface's part of the evaluation: facts, previews, and scores against a true surface.
#pragma once

#include "core/stage.h"
#include "eval/alignment.h"
#include "eval/evaluate.h"
#include "eval/mesh_metrics.h"
#include "eval/run_facts.h"
#include "eval/surface_model.h"
#include "eval/surface_pictures.h"
#include "image/image.h"
#include "mesh/mesh_facts.h"
#include "scene/scene.h"

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace tetrec {

struct SurfaceResult {
  std::string file;                         // as the surface stage names it
  MeshFacts facts;                          // in the units of the file
  std::optional<SurfaceScores> scores;      // with a ground-truth mesh
  std::optional<Alignment> alignment;       // with true cameras
  std::optional<SurfacePictures> pictures;  // with the run's scene
  std::vector<Image> color_pictures, clay_pictures;
  SurfaceModel model;  // for the report's 3-D scene
};

// Reads the mesh of the surface stage and takes its coordinates from the stage's manifest. Draws
// previews and scores its pictures against the rendered views if the run's scene is known, and
// compares the mesh with the input "ground-truth" of `stage` if there is one. Throws DataError.
SurfaceResult EvaluateSurface(const EvaluateOptions& options, const std::optional<Scene>& scene,
                              const RenderedViews& rendered, const StageFacts& surface_stage,
                              Stage& stage, std::vector<std::string>& warnings);

// The object "surface" of metrics.json.
nlohmann::json SurfaceJson(const SurfaceResult& surface, const EvaluateOptions& options);

}  // namespace tetrec
