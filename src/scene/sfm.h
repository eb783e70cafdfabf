// Structure from motion: a folder of photos becomes a scene folder, by way of COLMAP.
#pragma once

#include "core/stage.h"
#include "scene/colmap_model.h"
#include "scene/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct SfmOptions {
  std::string matcher = "auto";         // auto, exhaustive, sequential
  std::string camera_sharing = "auto";  // auto (one a picture size), single, per-folder, per-image
  std::string camera_model =
      "auto";               // auto, OPENCV, RADIAL, SIMPLE_RADIAL, PINHOLE, SIMPLE_PINHOLE
  int max_features = 3072;  // features a picture; those of the largest scales
  int max_size = 640;       // [px] longer side of the scene's pictures
  int holdout = 8;          // every N-th view is held out as test; 0: none
  int seed = 0;             // of COLMAP's mapper
};

// Throws UsageError naming the option and its value.
void CheckSfmOptions(const SfmOptions& options);

struct Photo {
  std::string name;  // relative to the folder, generic form
  int width = 0, height = 0;
  std::string sha256;
};

// JPEG and PNG files of the folder and below, sorted by name; hidden files are passed over. Each is
// decoded once; all that cannot be read are named in one DataError. Throws DataError for fewer
// than 2.
std::vector<Photo> FindPhotos(const std::filesystem::path& folder);

struct ModelQuality {
  size_t registered = 0, photos = 0, points = 0;
  double mean_error_px = 0, mean_track_length = 0;
};

// Whether the model can be built on. Throws DataError with what is wrong and the unregistered
// photos' names. Errors are judged in pixels of a photo of 1,600 px.
ModelQuality JudgeModel(const ColmapModel& model, const std::vector<std::string>& photo_names);

// PHOTOS -> images/*.png, scene.json, points.ply in the stage's folder.
void RunSfm(const SfmOptions& options, Stage& stage);

}  // namespace tetrec
