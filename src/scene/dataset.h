// What a data set with known cameras holds, whatever its format: pictures, where they were taken
// from, and the points that came with them. Nothing is decoded yet.
#pragma once

#include "geometry/bounds3.h"
#include "scene/colmap_model.h"
#include "scene/scene.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// A picture of a data set whose camera is known.
struct PosedPicture {
  std::string name;            // unique, as View::name, e.g. "train/r_0"
  std::string image;           // as View::image; empty: images/NAME.png
  std::filesystem::path file;  // exists (empty while a reader has not looked at what is missing)
  std::filesystem::path mask;  // may not exist; empty: none
  Split split = Split::kTrain;
  Rigid3 cam_from_input;  // camera frame as ours: x right, y down, z forward
  // The lens, in pixels of the file. Of width 0 where only the field of view is told, along one
  // axis (the other is 0: square pixels) or both.
  ColmapCamera lens;
  double horizontal_fov_rad = 0, vertical_fov_rad = 0;
};

struct Dataset {
  std::vector<PosedPicture> pictures;
  bool has_split = false;                  // else the importer chooses
  std::vector<ScenePoint> points;          // in the input's coordinates; track length 0: unknown
  std::optional<Bounds3> box_in_input;     // that the data set says to hold what matters
  std::vector<std::string> missing_files;  // files that are not there but often are
  std::vector<std::string> remarks;        // what else the user should know
  std::vector<std::string> skipped;        // names of pictures that are not there, left out
};

// What becomes of pictures that a data set names and that are not there.
enum class MissingPictures { kRefuse, kSkip };

// What import reads. kAuto: told by the files that are there.
enum class DatasetFormat { kAuto, kNerfSynthetic, kTransforms, kColmap };
template <>
inline constexpr auto kWords<DatasetFormat> =
    std::to_array<Word<DatasetFormat>>({{DatasetFormat::kAuto, "auto"},
                                        {DatasetFormat::kNerfSynthetic, "nerf-synthetic"},
                                        {DatasetFormat::kTransforms, "transforms"},
                                        {DatasetFormat::kColmap, "colmap"}});

// Throws DataError where the folder is none of the known formats, naming what was looked for.
DatasetFormat RecogniseDataset(const std::filesystem::path& folder);

// Throws DataError as the readers do. `images` is the folder of a COLMAP model's pictures (e.g.
// images_4; empty: images); UsageError where another format is read with one.
Dataset ReadDataset(const std::filesystem::path& folder, DatasetFormat format,
                    const std::string& images = "",
                    MissingPictures missing = MissingPictures::kRefuse);

// Where the pictures of these names are stored in a scene folder: images/STEM.png, or, where two
// names differ in no more than the extension, images/NAME.png of all.
std::vector<std::string> ImageFiles(const std::vector<std::string>& names);

}  // namespace tetrec
