// Links to photos, numbered by camera, and their masks.
#include "sfm/linked_photos.h"

#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "sfm/masks.h"

#include <fmt/format.h>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// Another phone or lens of it, another focal length and digital zoom may have the same size.
std::string CameraOf(const CameraNotes& notes) {
  return fmt::format("{}\n{}\n{:.3f} {} {:.3f}", notes.make, notes.model, notes.focal_length_mm,
                     notes.focal_length_35mm, notes.digital_zoom);
}

std::string CameraGroup(const Photo& photo, CameraSharing sharing) {
  const std::string size = fmt::format("{}x{}", photo.width, photo.height);
  switch (sharing) {
    case CameraSharing::kAuto:
      return size + CameraOf(photo.camera);
    case CameraSharing::kPerFolder:
      return size + fs::path(photo.name).parent_path().string();
    case CameraSharing::kPerImage:
      return photo.name;
    case CameraSharing::kSingle:
      break;
  }
  return size;
}

}  // namespace

bool LinkOrCopy(const fs::path& photo, const fs::path& link) {
  std::error_code error;
  fs::create_symlink(fs::absolute(photo), link, error);
  if (!error) return true;
  // Some file systems, such as exFAT, have no links.
  fs::copy_file(photo, link, fs::copy_options::overwrite_existing, error);
  if (error) {
    throw EnvironmentError(
        fmt::format("{}: {} can be neither linked nor copied to the file system of the run folder "
                    "({}); free some space, or choose another file system",
                    link.string(), photo.string(), error.message()));
  }
  return false;
}

LinkedPhotos LinkPhotos(const std::vector<Photo>& photos, CameraSharing sharing,
                        const fs::path& folder) {
  LinkedPhotos linked;
  linked.folder = folder;
  fs::remove_all(folder);
  std::map<std::string, size_t> groups;
  for (const Photo& photo : photos) groups.emplace(CameraGroup(photo, sharing), groups.size());
  if (sharing == CameraSharing::kSingle && groups.size() > 1) {
    throw DataError(
        fmt::format("the photos have {} different sizes, which one camera cannot have; use camera "
                    "sharing {}",
                    groups.size(), Name(CameraSharing::kAuto)));
  }
  linked.photos_of_camera.resize(groups.size());
  const size_t digits = std::to_string(photos.size()).size();
  size_t copies = 0;
  for (size_t i = 0; i < photos.size(); ++i) {
    const size_t camera = groups.at(CameraGroup(photos[i], sharing));
    ++linked.photos_of_camera[camera];
    const std::string group = sharing == CameraSharing::kPerImage ? "0" : std::to_string(camera);
    const std::string extension = photos[i].for_colmap.extension().string();
    const std::string name = fmt::format("{}/{:0{}}{}", group, i, digits, extension);
    fs::create_directories(folder / group);
    if (!LinkOrCopy(photos[i].for_colmap, folder / name)) ++copies;
    linked.names.push_back(name);
    linked.photo_of_name[name] = i;
  }
  if (copies > 0) {
    LogInfo("{}: the file system has no links; {} photos are copied for COLMAP", folder.string(),
            copies);
  }
  return linked;
}

void WriteColmapMasks(const std::vector<Photo>& photos, const fs::path& folder,
                      LinkedPhotos& linked) {
  if (photos.front().mask.empty()) return;
  fs::remove_all(folder);
  for (const std::string& name : linked.names) {
    fs::create_directories((folder / name).parent_path());
  }
  ParallelForEach(photos.size(), "", "nothing was done yet", [&](size_t i) {
    WriteColmapMask(folder / (linked.names[i] + ".png"), photos[i]);
  });
  linked.masks = folder;
}

}  // namespace tetrec
