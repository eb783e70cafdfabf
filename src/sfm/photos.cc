// The photos of a folder, and what COLMAP reads instead of those that it cannot.
#include "sfm/photos.h"

#include "core/checked_json.h"
#include "core/error.h"
#include "core/file.h"
#include "core/folder_files.h"
#include "core/log.h"
#include "core/lower_case.h"
#include "core/parallel.h"
#include "core/printable.h"
#include "core/short_list.h"
#include "image/exif.h"
#include "image/image.h"
#include "image/photo.h"
#include "image/tiff_file.h"
#include "sfm/data_set_folders.h"
#include "sfm/heic.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// The quality of the JPEG files that COLMAP reads instead of TIFF files and PNG files of 16 bits.
// The scene's pixels come from these files themselves.
constexpr int kQualityForColmap = 98;
constexpr uint64_t kMostBytesToConvert = uint64_t{1} << 31;

bool IsPhotoName(const fs::path& path) {
  const std::string extension = LowerExtension(path);
  return HasPhotoExtension(path) || extension == ".heic" || extension == ".heif" ||
         extension == ".hif";
}

// Images of kinds that are not read, judged by the name.
bool IsOtherImage(const fs::path& path) {
  static const std::set<std::string> kExtensions = {".avif", ".webp", ".bmp", ".gif", ".jp2",
                                                    ".jxl",  ".exr",  ".dng", ".cr2", ".cr3",
                                                    ".nef",  ".arw",  ".raf", ".orf", ".rw2"};
  return kExtensions.contains(LowerExtension(path));
}

bool IsHidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

std::vector<std::string> PhotoNames(const fs::path& folder, const fs::path& masks) {
  if (!fs::is_directory(folder)) {
    throw DataError(fmt::format("{}: is not a folder; give the folder that contains the photos",
                                folder.string()));
  }
  std::vector<std::string> names, unusable;
  std::vector<std::string> others, other_images;  // not read
  std::vector<std::string> copies;
  const auto enters = [&](const fs::path& subfolder) {
    std::error_code missing;
    if (HasReducedCopies(subfolder)) {
      copies.push_back(subfolder.lexically_relative(folder).generic_string());
      return false;
    }
    return !IsHidden(subfolder) && (masks.empty() || !fs::equivalent(subfolder, masks, missing));
  };
  for (const fs::path& file : FilesBelow(folder, enters)) {
    if (IsHidden(file)) continue;
    const std::string name = file.lexically_relative(folder).generic_string();
    if (IsPhotoName(file)) {
      StaysInside(name) ? names.push_back(name) : unusable.push_back(Printable(name));
    } else {
      (IsOtherImage(file) ? other_images : others).push_back(name);
    }
  }
  if (!unusable.empty()) {
    std::sort(unusable.begin(), unusable.end());
    throw DataError(
        fmt::format("{}: names of photos that are not UTF-8 or contain control characters: {}: {}; "
                    "rename them",
                    folder.string(), unusable.size(), ShortList(unusable)));
  }
  if (!copies.empty()) {
    LogInfo("{}: folders of reduced copies of the photos in images are left out: {}",
            folder.string(), ShortList(copies));
  }
  if (!others.empty()) {
    LogInfo("{}: files that are not photos are ignored: {}: {}", folder.string(), others.size(),
            ShortList(others));
  }
  if (!other_images.empty()) {
    LogWarning("{}: images other than JPEG, PNG, TIFF and HEIC are left out: {}: {}; convert them",
               folder.string(), other_images.size(), ShortList(other_images));
  }
  std::sort(names.begin(), names.end());
  return names;
}

// The limit on their share keeps a folder whose copy was cut off from becoming half a scene.
void WarnOrRefuse(const fs::path& folder, const std::vector<std::string>& unreadable,
                  const std::vector<std::string>& reasons, size_t files, double max_unreadable) {
  if (unreadable.empty()) return;
  const bool too_many = double(unreadable.size()) > max_unreadable * double(files);
  if (too_many) {
    throw DataError(fmt::format(
        "{}: {} of {} photos cannot be read, and max-unreadable is {}; copy them again, or remove "
        "them: {}",
        folder.string(), unreadable.size(), files, max_unreadable, ShortList(reasons)));
  }
  LogWarning("{} of {} photos cannot be read and are left out: {}", unreadable.size(), files,
             ShortList(reasons));
}

// One of two copies could be held out while the other is trained on, and so score too well.
void LeaveOutCopies(std::vector<Photo>& photos) {
  std::map<std::string, std::string> name_of_content;
  std::vector<std::string> copies;
  std::erase_if(photos, [&](const Photo& photo) {
    const auto [first, is_new] = name_of_content.emplace(photo.sha256, photo.name);
    if (!is_new) copies.push_back(fmt::format("{} (of {})", photo.name, first->second));
    return !is_new;
  });
  if (copies.empty()) return;
  LogWarning("photos that are exact copies of others are left out: {}: {}", copies.size(),
             ShortList(copies));
}

// A name of its own for each photo of the folder and each content of it.
fs::path ConvertedFile(const fs::path& converted, const std::string& name,
                       std::span<const uint8_t> bytes) {
  const std::string text = name + Sha256(bytes);
  const std::string key = Sha256({reinterpret_cast<const uint8_t*>(text.data()), text.size()});
  return converted / (key.substr(0, 24) + ".jpg");
}

void WriteForColmap(const Image& image, const CameraNotes& notes, const fs::path& jpeg) {
  Image rgb = image;
  if (image.channels == 4) rgb = CompositeOver(image, 0, 0, 0);
  WriteBytes(jpeg, WithExif(EncodeJpeg(rgb, kQualityForColmap), notes));
}

// Decodes the photo, and converts it if COLMAP cannot read it.
Photo ReadAndConvert(const fs::path& folder, const std::string& name, const fs::path& converted) {
  Photo photo;
  photo.name = name;
  photo.file = photo.for_colmap = folder / name;
  const std::vector<uint8_t> front = ReadFront(photo.file, 32);
  const bool is_heic = IsHeic(front), is_tiff = IsTiff(front), is_deep_png = IsDeepColorPng(front);
  if (is_heic || is_tiff || is_deep_png) {
    photo.for_colmap = ConvertedFile(converted, name, ReadBytes(photo.file, kMostBytesToConvert));
    fs::create_directories(converted);
  }
  if (is_heic) {
    if (!fs::exists(photo.for_colmap)) {
      ConvertHeic(photo.file, photo.for_colmap, photo.for_colmap.string() + ".part");
    }
    photo.file = photo.for_colmap;
  }
  PhotoNotes notes;
  const Image image = ReadPhoto(photo.file, &notes);
  // A converted HEIC photo is upright, whatever orientation its copied EXIF specifies.
  if (!is_heic) photo.quarter_turns = QuarterTurnsOf(notes.orientation);
  if ((is_tiff || is_deep_png) && !fs::exists(photo.for_colmap)) {
    WriteForColmap(image, notes.camera, photo.for_colmap);
  }
  photo.camera = notes.camera;
  photo.width = image.width;
  photo.height = image.height;
  photo.sha256 = Sha256OfFile(photo.for_colmap);
  return photo;
}

}  // namespace

PhotoFolder FindPhotos(const fs::path& folder, double max_unreadable, const fs::path& converted,
                       const fs::path& masks) {
  const std::vector<std::string> names = PhotoNames(folder, masks);
  WarnOfUnreadCameras(folder);
  if (names.empty()) {
    throw DataError(fmt::format(
        "{}: contains no photos (.jpg, .jpeg, .png, .tif, .tiff, .heic or .heif); convert other "
        "images to one of these",
        folder.string()));
  }
  if (names.size() < kFewestPhotos) {
    throw DataError(
        fmt::format("{}: contains only {} photo{} ({}); take at least {} of the same scene, better "
                    "20 or more",
                    folder.string(), names.size(), names.size() == 1 ? "" : "s", ShortList(names),
                    kFewestPhotos));
  }
  std::vector<Photo> photos(names.size());
  std::vector<std::string> errors(names.size());
  ParallelForEach(names.size(), "checking: photo", "nothing was done yet", [&](size_t i) {
    try {
      photos[i] = ReadAndConvert(folder, names[i], converted);
    } catch (const DataError& error) {
      errors[i] = error.what();
    }
  });
  PhotoFolder found;
  std::vector<std::string> reasons;
  for (size_t i = 0; i < names.size(); ++i) {
    if (errors[i].empty()) {
      found.photos.push_back(std::move(photos[i]));
    } else {
      found.unreadable.push_back(names[i]);
      reasons.push_back(errors[i]);
    }
  }
  WarnOrRefuse(folder, found.unreadable, reasons, names.size(), max_unreadable);
  LeaveOutCopies(found.photos);
  if (found.photos.size() < kFewestPhotos) {
    throw DataError(
        fmt::format("{}: only {} of {} photos can be read and are not copies of others; take at "
                    "least {} of the same scene, better 20 or more",
                    folder.string(), found.photos.size(), names.size(), kFewestPhotos));
  }
  return found;
}

}  // namespace tetrec
