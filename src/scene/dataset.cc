// Which reader reads a data set.
#include "scene/dataset.h"

#include "core/error.h"
#include "scene/colmap_dataset.h"
#include "scene/transforms.h"

#include <fmt/format.h>

namespace tetrec {

const char* Name(DatasetFormat format) {
  switch (format) {
    case DatasetFormat::kAuto:
      return "auto";
    case DatasetFormat::kNerfSynthetic:
      return "nerf-synthetic";
    case DatasetFormat::kTransforms:
      return "transforms";
    case DatasetFormat::kColmap:
      return "colmap";
  }
  return "?";
}

DatasetFormat RecogniseDataset(const std::filesystem::path& folder) {
  if (std::filesystem::is_regular_file(folder)) {
    throw DataError(fmt::format("{}: is a file; give the folder that it lies in, {}",
                                folder.string(), folder.parent_path().string()));
  }
  if (!std::filesystem::is_directory(folder)) {
    throw DataError(
        fmt::format("{}: no such folder; expected a data set with known cameras", folder.string()));
  }
  const auto has = [&](const char* file) { return std::filesystem::exists(folder / file); };
  if (has("transforms_train.json")) return DatasetFormat::kNerfSynthetic;
  if (has("transforms.json")) return DatasetFormat::kTransforms;
  if (FindColmapModel(folder)) return DatasetFormat::kColmap;
  throw DataError(fmt::format(
      "{}: is no data set with known cameras: neither transforms_train.json (NeRF-synthetic) nor "
      "transforms.json (instant-ngp, nerfstudio) nor cameras.bin or cameras.txt (COLMAP, also in "
      "sparse/0) is there; for photos alone use tetrec-sfm",
      folder.string()));
}

Dataset ReadDataset(const std::filesystem::path& folder, DatasetFormat format) {
  if (format == DatasetFormat::kAuto) format = RecogniseDataset(folder);
  if (format == DatasetFormat::kColmap) return ReadColmapDataset(folder);
  return format == DatasetFormat::kTransforms ? ReadTransforms(folder) : ReadNerfSynthetic(folder);
}

}  // namespace tetrec
