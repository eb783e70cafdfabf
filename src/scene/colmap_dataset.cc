// COLMAP models with their pictures as data sets.
#include "scene/colmap_dataset.h"

#include "core/error.h"
#include "scene/checked_json.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// images/ of the data set: beside the model, or in one of the folders above it.
fs::path FindImages(const fs::path& dataset, const fs::path& model) {
  for (fs::path above = model; above.string().size() >= dataset.string().size();
       above = above.parent_path()) {
    if (fs::is_directory(above / "images")) return above / "images";
    if (above == dataset) break;
  }
  throw DataError(fmt::format("{}: no folder images with the model's pictures in it or above it",
                              model.string()));
}

PosedPicture Posed(const ColmapImage& image, const ColmapCamera& camera, const fs::path& images) {
  const fs::path relative = fs::path(image.name).lexically_normal();
  if (!StaysInside(relative)) {
    throw DataError(fmt::format("{}: the model names the picture \"{}\"; expected a path inside it",
                                images.string(), image.name));
  }
  PosedPicture picture;
  picture.name = image.name;
  picture.file = images / relative;
  if (!fs::is_regular_file(picture.file)) {
    throw DataError(fmt::format("{}: the model's picture is not there", picture.file.string()));
  }
  picture.cam_from_input = image.cam_from_world;
  picture.lens = camera;
  return picture;
}

}  // namespace

std::optional<fs::path> FindColmapModel(const fs::path& folder) {
  for (const char* place : {"", "sparse/0", "sparse", "colmap/sparse/0", "colmap/sparse"}) {
    const fs::path model = (folder / place).lexically_normal();
    if (fs::exists(model / "cameras.bin") || fs::exists(model / "cameras.txt")) return model;
  }
  return std::nullopt;
}

Dataset ReadColmapDataset(const fs::path& folder) {
  const std::optional<fs::path> folder_of_model = FindColmapModel(folder);
  if (!folder_of_model) {
    throw DataError(fmt::format(
        "{}: no COLMAP model; expected cameras.bin or cameras.txt here, in sparse/0, sparse, "
        "colmap/sparse/0 or colmap/sparse",
        folder.string()));
  }
  const ColmapModel model = ReadColmapModel(*folder_of_model);
  const fs::path images = FindImages(folder.lexically_normal(), *folder_of_model);
  Dataset set;
  for (const auto& [id, image] : model.images) {
    set.pictures.push_back(Posed(image, model.cameras.at(image.camera), images));
  }
  std::sort(set.pictures.begin(), set.pictures.end(),
            [](const PosedPicture& a, const PosedPicture& b) { return a.name < b.name; });
  for (const auto& [id, point] : model.points) {
    set.points.push_back(
        {point.position, point.color_srgb, float(point.error_px), uint32_t(point.track.size())});
  }
  return set;
}

}  // namespace tetrec
