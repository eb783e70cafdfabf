// The content of a data set with known cameras, whatever its format: images, their cameras and
// poses, and the points that came with them. No image is decoded yet.
#pragma once

#include "geometry/bounds3.h"
#include "geometry/lens.h"
#include "scene/scene.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace tetrec {

// An image of a data set, with its known camera.
struct PosedPicture {
  std::string name;            // unique, as View::name, such as "train/r_0"
  std::string image;           // as View::image; set by ReadDataset
  std::filesystem::path file;  // exists; empty until a reader has handled missing images
  std::filesystem::path mask;  // may be missing; empty: no mask
  Split split = Split::kTrain;
  Rigid3 cam_from_input;  // camera axes: x right, y down, z forward
  // The lens, in pixels of the file. Its width is 0 if only the field of view is known, along one
  // axis (the other is 0: square pixels) or both.
  Lens lens;
  double horizontal_fov_rad = 0, vertical_fov_rad = 0;
};

struct Dataset {
  std::vector<PosedPicture> pictures;
  bool has_split = false;                  // false: the importer chooses one
  std::vector<ScenePoint> points;          // in the input's coordinates; track length 0: unknown
  std::optional<Bounds3> box_in_input;     // given by the data set as containing what matters
  std::vector<std::string> missing_files;  // files that such data sets often have
  std::vector<std::string> remarks;        // anything else the user should know
  std::vector<std::string> skipped;        // names of missing images that were left out
};

// What to do about images that a data set names but that are missing.
enum class MissingPictures { kRefuse, kSkip };

// How a data set is read.
struct DatasetReading {
  // The folder of images, such as images_4, in place of that of a COLMAP model (images) or of the
  // first folder of each path in transforms.json. Empty: as the data set has it.
  std::string images = {};
  MissingPictures missing = MissingPictures::kRefuse;
  bool points = true;  // false: its own points are not needed, a remark notes that it has some
};

// The formats that import reads. kAuto goes by the files that exist.
enum class DatasetFormat { kAuto, kNerfSynthetic, kTransforms, kColmap };
template <>
inline constexpr auto kWords<DatasetFormat> =
    std::to_array<Word<DatasetFormat>>({{DatasetFormat::kAuto, "auto"},
                                        {DatasetFormat::kNerfSynthetic, "nerf-synthetic"},
                                        {DatasetFormat::kTransforms, "transforms"},
                                        {DatasetFormat::kColmap, "colmap"}});

// The formats whose files the folder contains, the preferred one first; none for photos alone.
// RecogniseDataset prefers a COLMAP model to a transforms.json that has only the cameras of images.
std::vector<DatasetFormat> FormatsOf(const std::filesystem::path& folder);

// Throws DataError if the folder has none of the known formats, naming the files looked for.
DatasetFormat RecogniseDataset(const std::filesystem::path& folder);

// The remark on points that are not needed, because others are triangulated.
std::string PointsNotNeeded(const std::string& points);

// Throws DataError like the readers, and UsageError if a folder of images is given with
// NeRF-synthetic, which has one for each split.
Dataset ReadDataset(const std::filesystem::path& folder, DatasetFormat format,
                    const DatasetReading& reading = {});

}  // namespace tetrec
