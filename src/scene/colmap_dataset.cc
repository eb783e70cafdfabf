// COLMAP models with their pictures as data sets.
#include "scene/colmap_dataset.h"

#include "core/error.h"
#include "core/short_list.h"
#include "scene/checked_json.h"
#include "scene/image.h"
#include "scene/missing_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// Absolute, without a slash or dot at its end.
fs::path Plain(const fs::path& folder) {
  return (fs::absolute(folder) / "").lexically_normal().parent_path();
}

// The folder that holds that of the pictures: the model's, or one above it up to the data set's.
fs::path FolderOfImages(const fs::path& dataset, const fs::path& model, const std::string& images) {
  if (!StaysInside(images)) {
    throw UsageError(
        fmt::format("--images \"{}\": expected the name of a folder in the data set", images));
  }
  for (fs::path above = model;; above = above.parent_path()) {
    if (fs::is_directory(above / images)) return above;
    if (above == dataset || !above.has_relative_path()) break;
  }
  throw DataError(fmt::format(
      "{}: no folder {} with the model's pictures in it or above it, up to {}; --images tells "
      "another name",
      model.string(), images, dataset.string()));
}

// Empty where there is none.
fs::path FindMask(const fs::path& masks, const std::string& name) {
  const fs::path stem = fs::path(name).replace_extension();
  for (const std::string& file : {name + ".png", stem.generic_string() + ".png"}) {
    if (fs::is_regular_file(masks / file)) return masks / file;
  }
  return {};
}

void FindMasks(const fs::path& masks, Dataset& set) {
  if (!fs::is_directory(masks)) return;
  std::vector<std::string> without;
  for (PosedPicture& picture : set.pictures) {
    picture.mask = FindMask(masks, picture.name);
    if (picture.mask.empty()) without.push_back(picture.name);
  }
  if (without.size() == set.pictures.size()) {
    set.remarks.push_back(
        fmt::format("{}: holds no mask of any picture and is passed over; expected names as {}.png",
                    masks.string(), without[0]));
  }
}

// Pictures beside those of the model, which COLMAP did not register.
void CountOthers(const fs::path& images, Dataset& set) {
  std::set<std::string> known;
  for (const PosedPicture& picture : set.pictures) known.insert(picture.name);
  size_t others = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(images)) {
    const bool is_picture = HasPhotoExtension(entry.path()) && entry.is_regular_file();
    others +=
        is_picture && !known.contains(entry.path().lexically_relative(images).generic_string());
  }
  if (others == 0) return;
  set.remarks.push_back(
      fmt::format("{}: {} pictures are not in the model and left out", images.string(), others));
}

}  // namespace

std::optional<fs::path> FindColmapModel(const fs::path& folder) {
  for (const char* place : {"", "sparse/0", "sparse", "colmap/sparse/0", "colmap/sparse"}) {
    const fs::path model = Plain(folder / place);
    if (fs::exists(model / "cameras.bin") || fs::exists(model / "cameras.txt")) return model;
  }
  return std::nullopt;
}

Dataset ReadColmapDataset(const fs::path& folder, const std::string& images_name,
                          MissingPictures missing) {
  const std::optional<fs::path> folder_of_model = FindColmapModel(folder);
  if (!folder_of_model) {
    throw DataError(fmt::format(
        "{}: no COLMAP model; expected cameras.bin or cameras.txt here, in sparse/0, sparse, "
        "colmap/sparse/0 or colmap/sparse",
        folder.string()));
  }
  const ColmapModel model = ReadColmapModel(*folder_of_model);
  if (model.images.empty()) {
    throw DataError(fmt::format("{}: the model has no pictures", folder_of_model->string()));
  }
  const fs::path above = FolderOfImages(Plain(folder), *folder_of_model, images_name);
  const fs::path images = above / images_name;
  Dataset set;
  if (folder_of_model->filename() == "0" && fs::exists(folder_of_model->parent_path() / "1")) {
    set.remarks.push_back(
        fmt::format("{} holds several models: the first is taken, the others are not",
                    folder_of_model->parent_path().string()));
  }
  for (const auto& [id, image] : model.images) {
    PosedPicture picture;
    picture.name = image.name;
    std::error_code unusable;  // e.g. a name too long for the file system: not there either
    if (fs::is_regular_file(images / image.name, unusable)) picture.file = images / image.name;
    picture.cam_from_input = image.cam_from_world;
    picture.lens = model.cameras.at(image.camera);
    set.pictures.push_back(std::move(picture));
  }
  HandleMissingPictures(images, missing, set);
  CountOthers(images, set);
  std::sort(set.pictures.begin(), set.pictures.end(),
            [](const PosedPicture& a, const PosedPicture& b) { return a.name < b.name; });
  std::vector<std::string> names;
  for (const PosedPicture& picture : set.pictures) names.push_back(picture.name);
  const std::vector<std::string> files = ImageFiles(names);
  for (size_t i = 0; i < files.size(); ++i) set.pictures[i].image = files[i];
  FindMasks(above / "masks", set);
  for (const auto& [id, point] : model.points) {
    set.points.push_back(
        {point.position, point.color_srgb, float(point.error_px), uint32_t(point.track.size())});
  }
  return set;
}

}  // namespace tetrec
