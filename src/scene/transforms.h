// Readers of transforms JSON files: cameras along -z with y up, as OpenGL.
//
// NeRF-synthetic (Blender renderings with known cameras; Mildenhall et al. 2020):
// transforms_{train,val,test}.json, each {"camera_angle_x": horizontal field of view [rad],
// "frames": [{"file_path": "./train/r_0", "transform_matrix": 4 x 4 world from camera}]}.
#pragma once

#include "scene/dataset.h"

#include <filesystem>

namespace tetrec {

// Pictures in the order of the JSON files: train, val, test; train must be there. Throws DataError:
// transforms_train.json or a picture missing, a field missing or of a wrong kind, a matrix that is
// no rigid transform, an absurd field of view, a path that leaves the folder, a picture named
// twice.
Dataset ReadNerfSynthetic(const std::filesystem::path& folder);

// transforms.json of instant-ngp and nerfstudio. Throws DataError as ReadNerfSynthetic.
Dataset ReadTransforms(const std::filesystem::path& folder);

}  // namespace tetrec
