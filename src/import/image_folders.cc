// Folders of images other than the one that a data set names.
#include "import/image_folders.h"

#include "core/checked_json.h"
#include "core/error.h"
#include "core/folder_files.h"
#include "core/log.h"
#include "core/short_list.h"
#include "image/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// From names of images to the photos that are theirs.
using PhotoOfImage = std::map<std::string, std::string>;

std::map<std::string, std::vector<std::string>> ByStem(const std::vector<std::string>& files) {
  std::map<std::string, std::vector<std::string>> by_stem;
  for (const std::string& file : files) {
    by_stem[fs::path(file).replace_extension().generic_string()].push_back(file);
  }
  return by_stem;
}

// Where a stem belongs to several images or photos, any pair could be wrong.
PhotoOfImage PairByStem(const std::vector<std::string>& images,
                        const std::vector<std::string>& photos) {
  const auto photos_of = ByStem(photos);
  PhotoOfImage pairs;
  for (const auto& [stem, names] : ByStem(images)) {
    const auto found = photos_of.find(stem);
    if (found == photos_of.end() || found->second.size() > 1 || names.size() > 1) continue;
    pairs[names[0]] = found->second[0];
  }
  return pairs;
}

// True if the order of the names is that of their numbers: "10" comes before "9", but not "09".
bool HaveOneLength(const std::vector<std::string>& files) {
  const auto length = [](const std::string& file) { return fs::path(file).stem().string().size(); };
  return std::ranges::all_of(
      files, [&](const std::string& file) { return length(file) == length(files[0]); });
}

PhotoOfImage PairInOrder(const std::vector<std::string>& originals,
                         const std::vector<std::string>& photos) {
  PhotoOfImage pairs;
  if (originals.size() != photos.size() || !HaveOneLength(originals) || !HaveOneLength(photos)) {
    return pairs;
  }
  for (size_t i = 0; i < photos.size(); ++i) pairs[originals[i]] = photos[i];
  return pairs;
}

void TakeFiles(const fs::path& images, const PhotoOfImage& photo_of, const char* how,
               std::vector<PosedPicture>& pictures) {
  std::vector<std::string> found;
  for (PosedPicture& picture : pictures) {
    const auto photo = photo_of.find(picture.name);
    if (!picture.file.empty() || photo == photo_of.end()) continue;
    picture.file = images / photo->second;
    found.push_back(fmt::format("{} is {}", picture.name, photo->second));
  }
  if (found.empty()) return;
  LogInfo("{}: images with other names, found by {}: {}: {}", images.string(), how, found.size(),
          ShortList(found));
}

}  // namespace

void CheckImagesFolder(const std::string& images) {
  if (StaysInside(images)) return;
  throw UsageError(
      fmt::format("images is \"{}\"; expected the name of a folder in the data set", images));
}

std::string FindReducedCopies(const fs::path& images, const fs::path& image) {
  std::error_code unusable;
  if (fs::is_directory(images, unusable)) return {};
  for (const char* reduction : {"_2", "_4", "_8"}) {
    const std::string copies = images.filename().string() + reduction;
    if (fs::exists(images.parent_path() / copies / image, unusable)) return copies;
  }
  return {};
}

std::string AdviceOnCopies(const std::string& copies) {
  if (copies.empty()) return {};
  return fmt::format("; {0} has reduced copies, which --images {0} reads", copies);
}

std::vector<std::string> PhotosBelow(const fs::path& folder) {
  std::vector<std::string> photos;
  for (const fs::path& file : FilesBelow(folder)) {
    std::error_code gone;
    const bool is_photo = HasPhotoExtension(file) && !file.filename().string().starts_with('.') &&
                          fs::is_regular_file(file, gone);
    if (is_photo) photos.push_back(file.lexically_relative(folder).generic_string());
  }
  std::sort(photos.begin(), photos.end());
  return photos;
}

void FindRenamed(const fs::path& images, const fs::path& originals,
                 std::vector<PosedPicture>& pictures) {
  std::set<std::string> known;
  std::vector<std::string> missing;
  for (const PosedPicture& picture : pictures) {
    known.insert(picture.name);
    if (picture.file.empty()) missing.push_back(picture.name);
  }
  if (missing.empty()) return;
  std::vector<std::string> photos = PhotosBelow(images);
  std::erase_if(photos, [&](const std::string& photo) { return known.contains(photo); });
  const PhotoOfImage by_stem = PairByStem(missing, photos);
  TakeFiles(images, by_stem, "their stems", pictures);
  const bool none_is_found = by_stem.empty() && missing.size() == pictures.size();
  if (!none_is_found || !fs::is_directory(originals)) return;
  TakeFiles(images, PairInOrder(PhotosBelow(originals), photos),
            fmt::format("the order of those in {}", originals.filename().string()).c_str(),
            pictures);
}

}  // namespace tetrec
