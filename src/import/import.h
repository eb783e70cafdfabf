// Imports data sets with known cameras as scene folders.
#pragma once

#include "core/stage.h"
#include "import/dataset.h"
#include "scene/scene.h"
#include "sfm/triangulate.h"

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// What masks mean. kIgnore: black pixels show something that should not be modelled, such as people
// walking by, and do not count. kSubject: black pixels are empty and the others show the subject,
// as if the images had alpha. kNone: masks are not used.
enum class MaskUse { kIgnore, kSubject, kNone };
template <>
inline constexpr auto kWords<MaskUse> = std::to_array<Word<MaskUse>>(
    {{MaskUse::kIgnore, "ignore"}, {MaskUse::kSubject, "subject"}, {MaskUse::kNone, "none"}});

struct ImportOptions {
  DatasetFormat format = DatasetFormat::kAuto;
  std::string images;               // as DatasetReading's
  int max_size = 400;               // upper bound of the longer side [px]; 0: as stored
  std::optional<double> downscale;  // divides the images' sides, in place of max_size
  // White or black behind images with alpha; the scene's own background without alpha. Unset: white
  // behind alpha, otherwise the scene's own.
  std::optional<Background> background;
  MaskUse masks = MaskUse::kIgnore;
  bool triangulate = false;   // finds points in the images by COLMAP, with the cameras fixed
  bool skip_missing = false;  // leaves out images that are missing
  // Every N-th view by name is a test view, the others train; 0: none. Unset: the data set's own
  // split, or every 8th view if it holds out none.
  std::optional<int> holdout;
  std::filesystem::path test_list;         // lists the test views, the others train; empty: none
  std::optional<Bounds3> bounds_in_input;  // of the subject; unset: found from the data set
  void Check() const;                      // throws UsageError, which starts with the option's name
};

struct ImportedScene {
  Scene scene;
  size_t resized = 0;                          // images, including undistorted ones
  size_t turned = 0;                           // images rotated by their EXIF orientation
  size_t lenses_scaled = 0;                    // images smaller or larger than their camera
  size_t cut_to_plane = 0;                     // fisheye images, see UndistortedCamera
  uint64_t clipped_pixels = 0;                 // of EXR images, too bright for display
  size_t opaque = 0;                           // images with alpha or masks that hide nothing
  double masked_share = 0;                     // of all pixels, excluded by masks (kIgnore)
  std::vector<std::string> missing_files;      // as Dataset's
  std::vector<std::string> remarks;            // as Dataset's
  std::vector<std::string> skipped;            // as Dataset's
  std::optional<Triangulation> triangulation;  // its points are the scene's
  // Points dropped if the images have alpha.
  size_t points_transparent = 0;  // points of the data set that some training view sees through
  size_t points_out_of_bounds = 0;
};

// Reads the data set, undistorts and resizes its images (in parallel), finds the subject's bounds,
// moves the world so that the subject's longest side is 2 and its centre 0, and writes the scene
// folder. Alpha that is 255 in all images is dropped. Unless given, the bounds come from the first
// of these that exists: carving the training masks (images with alpha); the points; the data set's
// own box, if it contains no training camera and half of the training images show its centre; what
// all training cameras see; a box around the cameras, if they look outwards or all in one
// direction. The last two cause a warning. Images are read as stored; if only the image rotated by
// its EXIF orientation has the size of its camera, it is rotated. With `options.triangulate` COLMAP
// works at `place`. Throws DataError, and EnvironmentError about COLMAP.
ImportedScene ImportDataset(const std::filesystem::path& dataset,
                            const std::filesystem::path& folder, const ImportOptions& options,
                            const ColmapPlace& place = {});
// Its two parts. The first writes nothing: it reads all but the images, and chooses masks and
// split.
Dataset ReadForImport(const std::filesystem::path& dataset, const ImportOptions& options);
ImportedScene ImportDataset(const Dataset& set, const std::filesystem::path& folder,
                            const ImportOptions& options, const ColmapPlace& place);

// The stage; its inputs are "DATASET" and "test-list".
void RunImport(const ImportOptions& options, Stage& stage);

}  // namespace tetrec
