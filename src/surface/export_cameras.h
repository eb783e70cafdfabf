// The cameras of a run and its sparse points for other programs that fit fields to photos.
#pragma once

#include "colmap/model.h"
#include "core/stage.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"
#include "scene/scene.h"
#include "surface/export.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <optional>
#include <vector>

namespace tetrec {

// Views and points in the frame of the files: the training views from the cameras that the fit
// ended with, without the views that it left out, and the held-out views.
struct ExportedScene {
  std::filesystem::path folder;  // of the scene
  std::vector<Camera> cameras;
  std::vector<View> views;  // cam_from_world is from the frame of the files
  std::vector<ScenePoint> points;
};

// Nothing if no format asks for it. Throws DataError for the files of the scene.
std::optional<ExportedScene> SceneToExport(const ExportOptions& options,
                                           const std::filesystem::path& field_folder,
                                           const Similarity3& export_from_world);

// Image names are relative to the scene's folder of images. Points have no tracks, since a scene
// contains how many views see a point, but not which ones.
ColmapModel ColmapModelOf(const ExportedScene& scene);

// In the conventions of nerfstudio, without the points. Paths of images are relative to `folder`.
nlohmann::json TransformsOf(const ExportedScene& scene, const std::filesystem::path& folder);

// Writes what the formats ask for: the COLMAP model into the folder sparse/0; transforms.json, with
// points.ply beside it.
void WriteCameraExports(const ExportedScene& scene, const ExportOptions& options, Stage& stage);

}  // namespace tetrec
