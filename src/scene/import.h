// Data sets with known cameras into scene folders.
#pragma once

#include "core/stage.h"
#include "scene/dataset.h"
#include "scene/scene.h"
#include "scene/triangulate.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// What masks mean. kIgnore: what is black there is something that is not to be modelled (people
// walking by): those pixels count for nothing. kSubject: what is black there is empty, the rest is
// the subject, as if the pictures had alpha. kNone: nothing.
enum class MaskUse { kIgnore, kSubject, kNone };
template <>
inline constexpr auto kWords<MaskUse> = std::to_array<Word<MaskUse>>(
    {{MaskUse::kIgnore, "ignore"}, {MaskUse::kSubject, "subject"}, {MaskUse::kNone, "none"}});

struct ImportOptions {
  DatasetFormat format = DatasetFormat::kAuto;
  std::string images;               // folder of a COLMAP model's pictures; empty: images
  int max_size = 400;               // [px] bound of the longer side; 0: as stored
  std::optional<double> downscale;  // divides the pictures' sides, in place of max_size
  // Behind pictures with alpha white or black; without it: what the pictures stand before. Unset:
  // white, or the scene's own where there is no alpha.
  std::optional<Background> background;
  MaskUse masks = MaskUse::kIgnore;
  bool triangulate = false;   // points from the pictures and their cameras, by COLMAP
  bool skip_missing = false;  // leaves pictures out that are not there
  // Every n-th view by name is a test view, the others train; 0: none. Unset: the data set's own
  // split, or every 8th.
  std::optional<int> holdout;
  std::filesystem::path test_list;          // names the test views, the others train; empty: none
  std::optional<Bounds3> subject_in_input;  // in place of what the data set tells
  void Check() const;                       // throws UsageError naming the option and its value
};

struct ImportedScene {
  Scene scene;
  size_t resized = 0;                          // pictures, undistorted ones too
  size_t turned = 0;                           // pictures, by their EXIF orientation
  size_t lenses_scaled = 0;                    // pictures smaller or larger than their camera
  size_t cut_to_plane = 0;                     // pictures of fisheyes, see UndistortedCamera
  uint64_t clipped_pixels = 0;                 // of EXR pictures, too bright for display
  size_t opaque = 0;                           // pictures with alpha or masks that hide nothing
  double masked_share = 0;                     // of all pixels; of masks that leave pixels out
  std::vector<std::string> missing_files;      // as Dataset's
  std::vector<std::string> remarks;            // as Dataset's
  std::vector<std::string> skipped;            // as Dataset's
  std::optional<Triangulation> triangulation;  // its points are the scene's
  // Dropped where pictures have alpha.
  size_t points_transparent = 0;  // the data set's, where some training view sees through
  size_t points_out_of_bounds = 0;
};

// Reads the data set, brings its pictures to a pinhole camera and to size (in parallel), finds the
// subject's bounds, moves the world so that the subject's longest side is 2 and its centre 0, and
// writes the scene folder. Alpha that is 255 in all pictures is dropped. Bounds come from carving
// the training masks where there is alpha, else from the points, else from the data set's own box
// if that holds no training camera, else from what all training cameras see, else (they look
// outwards, or all one way) from a box around them, with a warning. Pixels are as stored; where
// only the picture turned by its EXIF orientation has the size that its camera tells, it is turned.
// With `options.triangulate` COLMAP works at `place`. Throws DataError, and EnvironmentError of
// COLMAP's.
ImportedScene ImportDataset(const std::filesystem::path& dataset,
                            const std::filesystem::path& folder, const ImportOptions& options,
                            const ColmapPlace& place = {});

// The stage: inputs "DATASET" and "test-list".
void RunImport(const ImportOptions& options, Stage& stage);

}  // namespace tetrec
