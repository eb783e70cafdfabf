// A scene: undistorted images, pinhole cameras, sparse points, bounds and split. Every kind of
// input becomes a scene folder, the only input of the later stages.
//
// A scene folder contains images/NAME.png (8-bit RGB, or RGBA with straight alpha), points.ply (x y
// z as double, red green blue, reprojection_error, track_length; absent if there are no points) and
// scene.json, with matrices by rows:
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

// Training views are optimised on, validation views are watched during optimisation, test views are
// judged at the end. Photo scenes have training and test views only.
enum class Split { kTrain, kValidation, kTest };
template <>
inline constexpr auto kWords<Split> = std::to_array<Word<Split>>(
    {{Split::kTrain, "train"}, {Split::kValidation, "validation"}, {Split::kTest, "test"}});

// What is behind everything: a constant colour for images with alpha, the scene's own far shell for
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
  uint32_t track_length = 0;  // number of views that see it
};

struct Scene {
  std::vector<Camera> cameras;
  std::vector<View> views;
  std::vector<ScenePoint> points;
  Bounds3 subject_bounds;  // the subject without the background
  Background background = Background::kScene;
  bool has_alpha = false;  // all images have alpha, the opacity of what they show
  // All images have an alpha channel that marks instead which pixels count: those of at least
  // kSeenAlpha. The others show something that is neither modelled nor judged. Excludes has_alpha.
  bool has_masks = false;
  // To the input's own coordinates (COLMAP model, transforms.json). The world has z up and is
  // scaled so that the subject's longest side is 2 and its centre is 0.
  Similarity3 input_from_world;

  std::vector<int> ViewsOf(Split split) const;
  // The test views if there are any, otherwise the validation views.
  std::vector<int> HeldOutViews() const;
};

// The least alpha of a pixel that counts in a scene with masks.
inline constexpr uint8_t kSeenAlpha = 128;

// Throws DataError naming the file and the field.
Scene ReadScene(const std::filesystem::path& folder);
// Writes scene.json and points.ply; the caller writes the images. Throws DataError for anything
// that ReadScene would refuse (values that are not finite, matrices that are not rotations, two
// views of one name).
void WriteScene(const std::filesystem::path& folder, const Scene& scene);

}  // namespace tetrec
