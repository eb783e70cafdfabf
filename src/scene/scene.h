// The scene folder: undistorted pictures, pinhole cameras, sparse points, bounds and split. Every
// input becomes this, and every later stage reads only this.
//
// On disk: images/NAME.png (8-bit RGB, or RGBA with straight alpha), points.ply (x y z as double,
// red green blue, reprojection_error, track_length; absent without points) and scene.json, matrices
// by rows:
//   {"schema": 1, "background": "white|black|scene", "has_alpha": bool, "has_masks": bool,
//    "point_count": N,
//    "subject_bounds": {"min": [x, y, z], "max": [x, y, z]},
//    "input_from_world": {"scale", "rotation": 3 x 3, "translation": [x, y, z]},
//    "cameras": [{"width", "height", "fx", "fy", "cx", "cy"}],
//    "views": [{"name", "image", "camera", "split": "train|validation|test",
//               "cam_from_world": {"rotation": 3 x 3, "translation": [x, y, z]}}]}
#pragma once

#include "core/words.h"
#include "geometry/bounds3.h"
#include "geometry/camera.h"
#include "geometry/rigid3.h"

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// train: optimised on; validation: watched while optimising; test: judged at the end. Photo scenes
// have train and test only.
enum class Split { kTrain, kValidation, kTest };
template <>
inline constexpr auto kWords<Split> = std::to_array<Word<Split>>(
    {{Split::kTrain, "train"}, {Split::kValidation, "validation"}, {Split::kTest, "test"}});

// What stands behind everything: a constant for pictures with alpha, the scene's own far shell for
// photos.
enum class Background { kWhite, kBlack, kScene };
template <>
inline constexpr auto kWords<Background> = std::to_array<Word<Background>>(
    {{Background::kWhite, "white"}, {Background::kBlack, "black"}, {Background::kScene, "scene"}});

struct View {
  std::string name;   // unique, e.g. "train/r_0" or "0001.jpg"
  std::string image;  // relative to the scene folder
  int camera = 0;     // index into Scene::cameras
  Rigid3 cam_from_world;
  Split split = Split::kTrain;
};

struct ScenePoint {
  glm::dvec3 position{0.0};  // [world units]
  std::array<uint8_t, 3> color_srgb{0, 0, 0};
  float reprojection_error_px = 0;
  uint32_t track_length = 0;  // views that see it
};

struct Scene {
  std::vector<Camera> cameras;
  std::vector<View> views;
  std::vector<ScenePoint> points;
  Bounds3 subject_bounds;  // the subject, told from the background
  Background background = Background::kScene;
  bool has_alpha = false;  // of all pictures: opacity of what they show
  // Of all pictures alpha tells instead which pixels count, from kSeenAlpha on; the others show
  // something that is not to be modelled nor judged. Never with has_alpha.
  bool has_masks = false;
  // The input's own coordinates (COLMAP model, transforms.json) from ours; exported meshes go back
  // through it. Our world is scaled so that the subject's longest side is 2 and its centre is 0.
  Similarity3 input_from_world;

  std::vector<int> ViewsOf(Split split) const;
  // Held-out views: test where there are any, else validation.
  std::vector<int> HeldOutViews() const;
};

inline constexpr uint8_t kSeenAlpha = 128;

// Throws DataError naming the file and the field.
Scene ReadScene(const std::filesystem::path& folder);
// Writes scene.json and points.ply; pictures are the caller's. Throws DataError for what ReadScene
// would not take (not finite, no rotation, two views of one name).
void WriteScene(const std::filesystem::path& folder, const Scene& scene);

}  // namespace tetrec
