// Readers of transforms JSON files: cameras along -z with y up, as OpenGL.
//
// NeRF-synthetic (Blender renderings with known cameras; Mildenhall et al. 2020):
// transforms_{train,val,test}.json, each {"camera_angle_x": horizontal field of view [rad],
// "frames": [{"file_path": "./train/r_0", "transform_matrix": 4 x 4 world from camera}]}.
//
// instant-ngp and nerfstudio: one transforms.json. In all of these files the lens stands in the
// frame or, for all frames, in the file:
//   w h                            picture size [px]
//   fl_x fl_y                      focal lengths [px], or as angles: camera_angle_x camera_angle_y
//                                  [rad], x_fov y_fov [degrees]; one of x and y is enough
//   cx cy                          principal point [px]; without it the middle
//   k1 k2 k3 p1 p2                 lens distortion as OpenCV (k1 to k4 of fisheyes)
//   distortion_params              all of it in one list, as nerfstudio: k1 k2 k3 k4 p1 p2
//   camera_model, is_fisheye       OPENCV_FISHEYE or one of the perspective models
// A frame may name a mask (mask_path). What else of these programs would change the result is
// warned of (alpha and masks that only lie beside a picture, colours that mean transparency) or
// refused (rolling_shutter; normal_mts_args and from_na, which mean other axes); depth pictures and
// all other fields are listed in the log as unused. The file may name sparse points
// (ply_file_path). The input's coordinates are those of transform_matrix and of the points: what
// nerfstudio's applied_transform and applied_scale or instant-ngp's scale and offset would do to
// them is not done or undone.
#pragma once

#include "scene/dataset.h"

#include <filesystem>

namespace tetrec {

// Pictures in the order of the JSON files: train, val, test; train must be there; pictures that are
// not: see HandleMissingPictures. Throws DataError: transforms_train.json or a mask missing, a
// field missing or of a wrong kind, a matrix that is no rigid transform, an absurd lens or one that
// is not read, a path that leaves the folder, a picture named twice.
Dataset ReadNerfSynthetic(const std::filesystem::path& folder,
                          MissingPictures missing = MissingPictures::kRefuse);

// transforms.json of instant-ngp and nerfstudio. Its split is nerfstudio's train_filenames,
// val_filenames and test_filenames, where there are any: frames in none of them are left out, with
// a warning, unless there is no train_filenames. Its box is aabb, or the cube of side aabb_scale
// around the middle of instant-ngp's own frame (input * scale + offset, 0.33 and 0.5 by default).
// Throws DataError as ReadNerfSynthetic.
Dataset ReadTransforms(const std::filesystem::path& folder,
                       MissingPictures missing = MissingPictures::kRefuse);

}  // namespace tetrec
