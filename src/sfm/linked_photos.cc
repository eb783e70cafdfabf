// Links to photos, numbered by camera, and their masks.
#include "sfm/linked_photos.h"

#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "sfm/masks.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// The same number for lengths that differ by hardly more than 2 %.
long Step(double length) { return length > 0 ? std::lround(std::log(length) / 0.02) : 0; }

// Another phone or lens of it, another focal length and digital zoom may have the same size.
std::string CameraOf(const CameraNotes& notes) {
  return fmt::format("{}\n{}\n{} {} {}", notes.make, notes.model, Step(notes.focal_length_mm),
                     Step(notes.focal_length_35mm), Step(notes.digital_zoom));
}

std::string CameraGroup(const Photo& photo, CameraSharing sharing) {
  const std::string size = fmt::format("{}x{}\n", photo.width, photo.height);
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
  std::error_code no_link, no_copy;
  fs::create_symlink(fs::absolute(photo), link, no_link);
  if (!no_link) return true;
  // Some file systems, such as exFAT, have no links.
  fs::copy_file(photo, link, fs::copy_options::overwrite_existing, no_copy);
  if (no_copy) {
    throw EnvironmentError(
        fmt::format("{}: {} can be neither linked ({}) nor copied ({}) to the file system of the "
                    "run folder; free some space, or choose another file system",
                    link.string(), photo.string(), no_link.message(), no_copy.message()));
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
    LogInfo("{}: links cannot be made on this file system; {} photos are copied for COLMAP",
            folder.string(), copies);
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
