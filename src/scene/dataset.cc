// Which reader reads a data set.
#include "scene/dataset.h"

#include "core/error.h"
#include "core/log.h"
#include "scene/colmap_dataset.h"
#include "scene/transforms.h"

#include <fmt/format.h>

#include <set>
#include <vector>

namespace tetrec {

DatasetFormat RecogniseDataset(const std::filesystem::path& folder) {
  if (std::filesystem::is_regular_file(folder)) {
    throw DataError(
        fmt::format("{}: is a file; of a data set give the folder that it lies in; a volume's name "
                    "ends in .raw (samples alone), .nrrd, .nhdr, .mha or .mhd",
                    folder.string()));
  }
  if (!std::filesystem::is_directory(folder)) {
    throw DataError(
        fmt::format("{}: no such folder; expected a data set with known cameras", folder.string()));
  }
  const auto has = [&](const char* file) { return std::filesystem::exists(folder / file); };
  std::vector<DatasetFormat> found;
  if (has("transforms_train.json")) found.push_back(DatasetFormat::kNerfSynthetic);
  if (has("transforms.json")) found.push_back(DatasetFormat::kTransforms);
  if (FindColmapModel(folder)) found.push_back(DatasetFormat::kColmap);
  for (size_t i = 1; i < found.size(); ++i) {
    LogInfo("{}: read as {}; {} is there too (--format)", folder.string(), Name(found[0]),
            Name(found[i]));
  }
  if (!found.empty()) return found[0];
  throw DataError(fmt::format(
      "{}: is no data set with known cameras: neither transforms_train.json (NeRF-synthetic) nor "
      "transforms.json (instant-ngp, nerfstudio) nor cameras.bin or cameras.txt (COLMAP, also in "
      "sparse/0) is there; for photos alone use tetrec-sfm",
      folder.string()));
}

Dataset ReadDataset(const std::filesystem::path& folder, DatasetFormat format,
                    const std::string& images, MissingPictures missing) {
  if (format == DatasetFormat::kAuto) format = RecogniseDataset(folder);
  if (format == DatasetFormat::kColmap) {
    return ReadColmapDataset(folder, images.empty() ? "images" : images, missing);
  }
  if (!images.empty()) {
    throw UsageError(fmt::format(
        "--images {}: only of COLMAP models; {} is read as {}, which names its pictures", images,
        folder.string(), Name(format)));
  }
  return format == DatasetFormat::kTransforms ? ReadTransforms(folder, missing)
                                              : ReadNerfSynthetic(folder, missing);
}

std::vector<std::string> ImageFiles(const std::vector<std::string>& names) {
  std::vector<std::string> files;
  std::set<std::string> stems;
  for (const std::string& name : names) {
    const std::string stem = std::filesystem::path(name).replace_extension().generic_string();
    stems.insert(stem);
    files.push_back(fmt::format("images/{}.png", stem));
  }
  if (stems.size() < names.size()) {
    for (size_t i = 0; i < names.size(); ++i) files[i] = fmt::format("images/{}.png", names[i]);
  }
  return files;
}

}  // namespace tetrec
