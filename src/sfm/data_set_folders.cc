// What a folder of photos contains if it is a data set.
#include "sfm/data_set_folders.h"

#include "core/log.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

bool HasFolder(const fs::path& folder, const char* name) {
  std::error_code unusable;
  return fs::is_directory(folder / name, unusable);
}

bool HasFile(const fs::path& folder, const char* name) {
  std::error_code unusable;
  return fs::is_regular_file(folder / name, unusable);
}

bool HasCameraTexts(const fs::path& folder) {
  std::error_code unusable;
  return std::any_of(fs::directory_iterator(folder, unusable), fs::directory_iterator(),
                     [](const fs::directory_entry& entry) {
                       return entry.path().filename().string().ends_with("_cam.txt");
                     });
}

// The file or folder that contains the cameras; empty if there is none.
std::string UnreadCameras(const fs::path& folder) {
  for (const char* file : {"cameras_sphere.npz", "cameras.npz", "poses_bounds.npy"}) {
    if (HasFile(folder, file)) return file;
  }
  if (HasFolder(folder, "pose") && HasFile(folder, "intrinsics.txt")) return "pose";
  if (HasCameraTexts(folder / "cams")) return "cams";
  return {};
}

// Other folders, of masks or depths, contain images that are no photos.
std::string AdviceOnImages(const fs::path& folder) {
  for (const char* images : {"images", "image", "rgb"}) {
    if (!HasFolder(folder, images)) continue;
    return fmt::format("; give {}, so that no other images count as photos",
                       (folder / images).string());
  }
  return {};
}

size_t CountFiles(const fs::path& folder) {
  std::error_code unusable;
  return size_t(std::count_if(fs::directory_iterator(folder, unusable), fs::directory_iterator(),
                              [](const fs::directory_entry& entry) {
                                std::error_code unreadable;
                                return entry.is_regular_file(unreadable);
                              }));
}

}  // namespace

void WarnOfUnreadCameras(const fs::path& folder) {
  const std::string cameras = UnreadCameras(folder);
  if (cameras.empty()) return;
  LogWarning("{}: the known cameras in {} are of a format that is not supported and are ignored{}",
             folder.string(), cameras, AdviceOnImages(folder));
}

bool HasReducedCopies(const fs::path& folder) {
  const std::string name = folder.filename().string();
  const bool is_reduced = name == "images_2" || name == "images_4" || name == "images_8";
  const fs::path images = folder.parent_path() / "images";
  return is_reduced && HasFolder(folder.parent_path(), "images") &&
         CountFiles(images) >= CountFiles(folder);
}

}  // namespace tetrec
