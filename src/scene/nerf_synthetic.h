// Reader of NeRF-synthetic folders (Blender renderings with known cameras; Mildenhall et al. 2020):
// transforms_{train,val,test}.json, each {"camera_angle_x": horizontal field of view [rad],
// "frames": [{"file_path": "./train/r_0", "transform_matrix": 4 x 4 world from camera}]} with the
// camera looking along -z and y up, as OpenGL.
#pragma once

#include "geometry/rigid3.h"
#include "scene/scene.h"

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// A picture of a data set whose camera is known; nothing is decoded yet.
struct PosedPicture {
  std::string name;            // unique, without extension, e.g. "train/r_0"
  std::filesystem::path file;  // exists
  Split split = Split::kTrain;
  double horizontal_fov_rad = 0;
  Rigid3 cam_from_input;  // camera frame as ours: x right, y down, z forward
};

struct NerfSynthetic {
  std::vector<PosedPicture> pictures;       // in the order of the JSON files: train, val, test
  std::vector<std::string> missing_splits;  // files that are not there; train always is
};

// Throws DataError: transforms_train.json or a picture missing, a field missing or of a wrong kind,
// a matrix that is no rigid transform, an absurd field of view, a path that leaves the folder, a
// picture named twice.
NerfSynthetic ReadNerfSynthetic(const std::filesystem::path& folder);

}  // namespace tetrec
