// Chooses the reader for a data set.
#include "import/dataset.h"

#include "core/error.h"
#include "core/log.h"
#include "import/colmap_dataset.h"
#include "import/transforms.h"
#include "scene/image_files.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

namespace tetrec {
namespace {

Dataset ReadInFormat(const std::filesystem::path& folder, DatasetFormat format,
                     const DatasetReading& reading) {
  if (format == DatasetFormat::kColmap) return ReadColmapDataset(folder, reading);
  if (format == DatasetFormat::kTransforms) return ReadTransforms(folder, reading);
  if (!reading.images.empty()) {
    throw UsageError(fmt::format(
        "images is \"{}\", but only a COLMAP model and transforms.json have a folder of images to "
        "choose; {} is read as {}",
        reading.images, folder.string(), Name(format)));
  }
  return ReadNerfSynthetic(folder, reading);
}

}  // namespace

std::vector<DatasetFormat> FormatsOf(const std::filesystem::path& folder) {
  const auto has = [&](const char* file) { return std::filesystem::exists(folder / file); };
  std::vector<DatasetFormat> found;
  if (has("transforms_train.json")) found.push_back(DatasetFormat::kNerfSynthetic);
  if (has("transforms.json")) found.push_back(DatasetFormat::kTransforms);
  if (FindColmapModel(folder)) found.push_back(DatasetFormat::kColmap);
  return found;
}

DatasetFormat RecogniseDataset(const std::filesystem::path& folder) {
  if (std::filesystem::is_regular_file(folder)) {
    throw DataError(
        fmt::format("{}: is a file; give the folder of a data set, or a volume, whose name ends in "
                    ".raw (samples alone), .nrrd, .nhdr, .mha or .mhd",
                    folder.string()));
  }
  if (!std::filesystem::is_directory(folder)) {
    throw DataError(
        fmt::format("{}: no such folder; expected a data set with known cameras", folder.string()));
  }
  std::vector<DatasetFormat> found = FormatsOf(folder);
  const char* why = "";
  if (found == std::vector{DatasetFormat::kTransforms, DatasetFormat::kColmap} &&
      HasWholeColmapModel(folder) && !HasMoreThanCameras(folder)) {
    std::swap(found[0], found[1]);
    why = ", since its transforms.json has no points, masks or split";
  }
  for (size_t i = 1; i < found.size(); ++i) {
    LogInfo("{}: read as {}{}; it is {} as well (choose another format to read that)",
            folder.string(), Name(found[0]), why, Name(found[i]));
  }
  if (!found.empty()) return found[0];
  throw DataError(
      fmt::format("{}: is not a data set with known cameras: it has neither transforms_train.json "
                  "(NeRF-synthetic) nor transforms.json (instant-ngp, nerfstudio) nor cameras.bin "
                  "or cameras.txt "
                  "(COLMAP, also in sparse/0); for photos alone use tetrec-sfm",
                  folder.string()));
}

std::string PointsNotNeeded(const std::string& points) {
  return fmt::format("{}: points of the data set, not used: triangulated points replace them",
                     points);
}

Dataset ReadDataset(const std::filesystem::path& folder, DatasetFormat format,
                    const DatasetReading& reading) {
  Dataset set = ReadInFormat(
      folder, format == DatasetFormat::kAuto ? RecogniseDataset(folder) : format, reading);
  std::vector<std::string> names;
  for (const PosedPicture& picture : set.pictures) names.push_back(picture.name);
  const std::vector<std::string> files = ImageFiles(names);
  for (size_t i = 0; i < files.size(); ++i) set.pictures[i].image = files[i];
  return set;
}

}  // namespace tetrec
