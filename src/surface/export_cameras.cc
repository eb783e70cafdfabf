// Cameras and points as COLMAP's model and as transforms.json.
#include "surface/export_cameras.h"

#include "colmap/write_model.h"
#include "core/file.h"
#include "core/log.h"
#include "core/manifest.h"
#include "core/progress.h"
#include "geometry/rotation.h"
#include "scene/points.h"
#include "surface/trained_views.h"

#include <map>
#include <string>
#include <utility>

namespace tetrec {
namespace {
namespace fs = std::filesystem;

// The rows of the camera's pose with OpenGL's axes: x right, y up, z back.
nlohmann::json OpenGlPose(const Rigid3& cam_from_export) {
  const Rigid3 pose = cam_from_export.Inverse();
  nlohmann::json rows = nlohmann::json::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back({pose.rotation[0][row], -pose.rotation[1][row], -pose.rotation[2][row],
                    pose.translation[row]});
  }
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}

nlohmann::json FrameOf(const View& view, const Camera& camera, const std::string& file) {
  return {{"file_path", file},  {"w", camera.width},
          {"h", camera.height}, {"fl_x", camera.fx},
          {"fl_y", camera.fy},  {"cx", camera.cx},
          {"cy", camera.cy},    {"transform_matrix", OpenGlPose(view.cam_from_world)}};
}

// nerfstudio wants all three lists if there is one. Where only one of the held-out splits exists,
// it is both.
void AddSplits(const std::map<Split, std::vector<std::string>>& files, nlohmann::json& transforms) {
  const auto of = [&](Split split) {
    const auto found = files.find(split);
    return found == files.end() ? std::vector<std::string>() : found->second;
  };
  const std::vector<std::string> validation = of(Split::kValidation), test = of(Split::kTest);
  if (validation.empty() && test.empty()) return;
  transforms["train_filenames"] = of(Split::kTrain);
  transforms["val_filenames"] = validation.empty() ? test : validation;
  transforms["test_filenames"] = test.empty() ? validation : test;
}

}  // namespace

std::optional<ExportedScene> SceneToExport(const ExportOptions& options,
                                           const fs::path& field_folder,
                                           const Similarity3& export_from_world) {
  if (!options.Wants(ExportFormat::kColmap) && !options.Wants(ExportFormat::kTransforms)) return {};
  ExportedScene exported;
  exported.folder = PreviousStage(field_folder, {"sfm", "import"});
  Scene scene = ReadScene(exported.folder);
  std::map<size_t, Rigid3> trained;
  for (const TrainedView& view : TrainedViews(scene, field_folder)) {
    trained.emplace(view.index, view.cam_from_world);
  }
  const Similarity3 world_from_export = export_from_world.Inverse();
  for (size_t v = 0; v < scene.views.size(); ++v) {
    View view = scene.views[v];
    if (view.split == Split::kTrain) {
      const auto found = trained.find(v);
      if (found == trained.end()) continue;
      view.cam_from_world = found->second;
    }
    view.cam_from_world = CamFromWorld(view.cam_from_world, world_from_export);
    exported.views.push_back(std::move(view));
  }
  exported.cameras = std::move(scene.cameras);
  exported.points = std::move(scene.points);
  for (ScenePoint& point : exported.points) point.position = export_from_world * point.position;
  return exported;
}

ColmapModel ColmapModelOf(const ExportedScene& scene) {
  ColmapModel model;
  for (size_t i = 0; i < scene.cameras.size(); ++i) {
    model.cameras[uint32_t(i + 1)] = PinholeLens(scene.cameras[i]);
  }
  for (size_t i = 0; i < scene.views.size(); ++i) {
    const View& view = scene.views[i];
    model.images[uint32_t(i + 1)] = {.name = fs::path(view.image).lexically_relative("images"),
                                     .camera = uint32_t(view.camera + 1),
                                     .cam_from_world = view.cam_from_world};
  }
  for (size_t i = 0; i < scene.points.size(); ++i) {
    const ScenePoint& point = scene.points[i];
    model.points[i + 1] = {.position = point.position,
                           .color_srgb = point.color_srgb,
                           .error_px = double(point.reprojection_error_px)};
  }
  return model;
}

nlohmann::json TransformsOf(const ExportedScene& scene, const fs::path& folder) {
  nlohmann::json transforms = {{"camera_model", "PINHOLE"}, {"frames", nlohmann::json::array()}};
  std::map<Split, std::vector<std::string>> files;
  for (const View& view : scene.views) {
    const std::string file = fs::relative(scene.folder / view.image, folder).string();
    transforms["frames"].push_back(FrameOf(view, scene.cameras[size_t(view.camera)], file));
    files[view.split].push_back(file);
  }
  AddSplits(files, transforms);
  return transforms;
}

void WriteCameraExports(const ExportedScene& scene, const ExportOptions& options, Stage& stage) {
  if (options.Wants(ExportFormat::kColmap)) {
    WriteColmapModel(stage.Output("sparse") / "0", ColmapModelOf(scene));
  }
  if (options.Wants(ExportFormat::kTransforms)) {
    nlohmann::json transforms = TransformsOf(scene, stage.folder());
    if (!scene.points.empty()) {
      constexpr const char* kPointsFile = "points.ply";
      WriteScenePoints(stage.Output(kPointsFile), scene.points);
      transforms["ply_file_path"] = kPointsFile;
    }
    WriteText(stage.Output("transforms.json"), transforms.dump(1) + "\n");
  }
  LogInfo("cameras: {} are exported, and {} points", WithThousands(scene.views.size()),
          WithThousands(scene.points.size()));
  stage.Count("exported_cameras", scene.views.size());
}

}  // namespace tetrec
