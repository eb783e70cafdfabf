// Data sets of a COLMAP model and its images.
#include "import/colmap_dataset.h"

#include "colmap/model.h"
#include "core/error.h"
#include "import/image_folders.h"
#include "import/missing_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <set>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

constexpr const char* kImages = "images";

// The absolute path without a slash or dot at its end.
fs::path Plain(const fs::path& folder) {
  return (fs::absolute(folder) / "").lexically_normal().parent_path();
}

// The model's folder and those above it up to the data set's.
std::vector<fs::path> FoldersAbove(const fs::path& dataset, const fs::path& model) {
  std::vector<fs::path> folders;
  for (fs::path above = model;; above = above.parent_path()) {
    folders.push_back(above);
    if (above == dataset || !above.has_relative_path()) return folders;
  }
}

// The folder that contains the folder of images; empty if there is none.
fs::path FindFolderOfImages(const fs::path& dataset, const fs::path& model,
                            const std::string& images) {
  if (Plain(dataset / images) == dataset) return dataset;
  for (const fs::path& above : FoldersAbove(dataset, model)) {
    if (fs::is_directory(above / images)) return above;
  }
  return {};
}

fs::path FolderOfImages(const fs::path& dataset, const fs::path& model, const std::string& images) {
  CheckImagesFolder(images);
  if (fs::path found = FindFolderOfImages(dataset, model, images); !found.empty()) return found;
  std::string copies;
  for (const fs::path& above : FoldersAbove(dataset, model)) {
    if (copies.empty()) copies = FindReducedCopies(above / images, "");
  }
  throw DataError(fmt::format(
      "{}: no folder {} with the model's images in it or above it, up to {}; if it has another "
      "name, give that as the folder of images{}",
      model.string(), images, dataset.string(), AdviceOnCopies(copies)));
}

MissingPhrases PhrasesOnImages(const DatasetReading& reading) {
  if (reading.images.empty()) return {};
  return {.tried = ", also with other extensions",
          .advice = fmt::format("; leave out --images to read {}", kImages)};
}

// Empty if there is none.
fs::path FindMask(const fs::path& masks, const std::string& name) {
  const fs::path stem = fs::path(name).replace_extension();
  for (const std::string& file : {name + ".png", stem.generic_string() + ".png"}) {
    if (fs::is_regular_file(masks / file)) return masks / file;
  }
  return {};
}

void FindMasks(const fs::path& above, Dataset& set) {
  const fs::path masks = above / "masks";
  if (!fs::is_directory(masks)) {
    if (!fs::is_directory(above / "mask")) return;
    set.remarks.push_back(
        fmt::format("{} is ignored; masks are read from masks, under names like {}.png",
                    (above / "mask").string(), set.pictures[0].name));
    return;
  }
  std::vector<std::string> without;
  for (PosedPicture& picture : set.pictures) {
    picture.mask = FindMask(masks, picture.name);
    if (picture.mask.empty()) without.push_back(picture.name);
  }
  if (without.size() == set.pictures.size()) {
    set.remarks.push_back(
        fmt::format("{}: contains no mask of any image and is ignored; expected names like {}.png",
                    masks.string(), without[0]));
  }
}

// Counts the images that are not in the model because COLMAP did not register them.
void CountOthers(const fs::path& images, Dataset& set) {
  std::set<fs::path> known;
  for (const PosedPicture& picture : set.pictures) known.insert(picture.file);
  const std::vector<std::string> photos = PhotosBelow(images);
  const auto others = std::count_if(photos.begin(), photos.end(), [&](const std::string& photo) {
    return !known.contains(images / photo);
  });
  if (others == 0) return;
  set.remarks.push_back(
      fmt::format("{}: {} images are not in the model and are left out", images.string(), others));
}

std::vector<ScenePoint> PointsOf(const ColmapModel& model) {
  std::vector<ScenePoint> points;
  for (const auto& [id, point] : model.points) {
    points.push_back(
        {point.position, point.color_srgb, float(point.error_px), uint32_t(point.track.size())});
  }
  return points;
}

}  // namespace

std::optional<fs::path> FindColmapModel(const fs::path& folder) {
  for (const char* place : {"", "sparse/0", "sparse", "colmap/sparse/0", "colmap/sparse"}) {
    const fs::path model = Plain(folder / place);
    if (fs::exists(model / "cameras.bin") || fs::exists(model / "cameras.txt")) return model;
  }
  return std::nullopt;
}

bool HasWholeColmapModel(const fs::path& folder) {
  const std::optional<fs::path> model = FindColmapModel(folder);
  if (!model || FindFolderOfImages(Plain(folder), *model, kImages).empty()) return false;
  const auto has_all = [&](const char* extension) {
    return std::ranges::all_of(std::array{"cameras", "images", "points3D"}, [&](const char* part) {
      return fs::exists(*model / (std::string(part) + extension));
    });
  };
  return has_all(".bin") || has_all(".txt");
}

Dataset ReadColmapDataset(const fs::path& folder, const DatasetReading& reading) {
  const std::optional<fs::path> folder_of_model = FindColmapModel(folder);
  if (!folder_of_model) {
    throw DataError(fmt::format(
        "{}: no COLMAP model; expected cameras.bin or cameras.txt here, in sparse/0, sparse, "
        "colmap/sparse/0 or colmap/sparse",
        folder.string()));
  }
  const ColmapModel model = ReadColmapModel(*folder_of_model, DanglingReferences::kDrop);
  if (model.images.empty()) {
    throw DataError(fmt::format("{}: the model has no images", folder_of_model->string()));
  }
  const std::string images_name = reading.images.empty() ? kImages : reading.images;
  const fs::path above = FolderOfImages(Plain(folder), *folder_of_model, images_name);
  const fs::path images = Plain(above / images_name);
  Dataset set;
  if (folder_of_model->filename() == "0" && fs::exists(folder_of_model->parent_path() / "1")) {
    set.remarks.push_back(
        fmt::format("{} contains several models: the first is read, the others are not",
                    folder_of_model->parent_path().string()));
  }
  for (const auto& [id, image] : model.images) {
    PosedPicture picture;
    picture.name = image.name;
    std::error_code
        unusable;  // such as a name too long for the file system, which does not exist either
    if (fs::is_regular_file(images / image.name, unusable)) picture.file = images / image.name;
    picture.cam_from_input = image.cam_from_world;
    picture.lens = model.cameras.at(image.camera);
    set.pictures.push_back(std::move(picture));
  }
  FindRenamed(images, above / kImages, set.pictures);
  HandleMissingPictures(images, reading.missing, set, PhrasesOnImages(reading));
  // A data set's own folder may contain images of other kinds.
  if (images != Plain(folder)) CountOthers(images, set);
  std::sort(set.pictures.begin(), set.pictures.end(),
            [](const PosedPicture& a, const PosedPicture& b) { return a.name < b.name; });
  FindMasks(above, set);
  if (reading.points) {
    set.points = PointsOf(model);
  } else if (!model.points.empty()) {
    set.remarks.push_back(PointsNotNeeded(folder_of_model->string()));
  }
  return set;
}

}  // namespace tetrec
