// Readers of transforms JSON files, whose cameras look along -z with y up, as in OpenGL.
//
// NeRF-synthetic (Blender renderings with known cameras; Mildenhall et al. 2020):
// transforms_{train,val,test}.json, each {"camera_angle_x": horizontal field of view [rad],
// "frames": [{"file_path": "./train/r_0", "transform_matrix": 4 x 4 world from camera}]}.
//
// instant-ngp and nerfstudio have one transforms.json. In all of these files the lens is specified
// in each frame or, for all frames, at the top level:
//   w h                            image size [px]
//   fl_x fl_y                      focal lengths [px], or as angles: camera_angle_x camera_angle_y
//                                  [rad], x_fov y_fov [degrees]; one of x and y suffices
//   cx cy                          principal point [px]; by default the middle
//   k1 k2 k3 p1 p2                 lens distortion as in OpenCV (k1 to k4, p1, p2 for fisheyes)
//   distortion_params              all of it as nerfstudio's list k1 k2 k3 k4 p1 p2
//   camera_model, is_fisheye       OPENCV_FISHEYE or one of the perspective models
// Coefficients of the distortion may be text ("0.01").
// A frame may name a mask (mask_path). Other features of these programs that would change the
// result cause a warning (alpha and masks in files beside an image, colours that mean transparency)
// or are refused (rolling_shutter; normal_mts_args and from_na, which mean other axes). Depth
// images and all other fields are listed in the log as unused. The file may name sparse points
// (ply_file_path). The input's coordinates are those of transform_matrix and of the points;
// nerfstudio's applied_transform and applied_scale and instant-ngp's scale and offset are neither
// applied nor undone.
#pragma once

#include "import/dataset.h"

#include <filesystem>

namespace tetrec {

// Pictures are in the order of the JSON files train, val and test, of which train must exist. For
// missing images see HandleMissingPictures. Throws DataError for a missing transforms_train.json, a
// field that is missing or of the wrong kind, a matrix that is not a rigid transform, a lens that
// is absurd or not supported, a path that leaves the folder, and an image that is listed twice.
Dataset ReadNerfSynthetic(const std::filesystem::path& folder, const DatasetReading& reading = {});

// True if transforms.json has more than cameras: points that exist, masks or a split.
// Throws DataError for a field of the wrong kind.
bool HasMoreThanCameras(const std::filesystem::path& folder);

// transforms.json of instant-ngp and nerfstudio. Its split is nerfstudio's train_filenames,
// val_filenames and test_filenames, if any: frames in none of them are left out, with a warning,
// unless there is no train_filenames. Its box is aabb, or the cube of side aabb_scale around the
// middle of instant-ngp's own frame (input * scale + offset, by default 0.33 and 0.5). Throws
// DataError like ReadNerfSynthetic, and UsageError if the folder of images leaves the data set's.
Dataset ReadTransforms(const std::filesystem::path& folder, const DatasetReading& reading = {});

}  // namespace tetrec
