// The photos under names that COLMAP can read.
#pragma once

#include "sfm/options.h"
#include "sfm/photos.h"

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace tetrec {

// COLMAP's view of the photos: links (or copies) with plain names, in one folder per camera, whose
// file names sort like the photos. The user's names may contain spaces, which COLMAP's lists
// cannot.
struct LinkedPhotos {
  std::filesystem::path folder;
  std::filesystem::path masks;     // NAME.png for each name; empty if there are none
  std::vector<std::string> names;  // in the order of the photos
  std::map<std::string, size_t> photo_of_name;
  std::vector<size_t> photos_of_camera;  // their number, for each camera
};

// Makes a link to a photo, or a copy of it where the file system has no links, which returns false.
// Throws EnvironmentError if that fails, too.
bool LinkOrCopy(const std::filesystem::path& photo, const std::filesystem::path& link);

// Makes `folder` anew. Throws DataError if one camera is to have taken photos of several sizes.
LinkedPhotos LinkPhotos(const std::vector<Photo>& photos, CameraSharing sharing,
                        const std::filesystem::path& folder);

// Writes the masks, if there are any, under the names of the photos' links.
void WriteColmapMasks(const std::vector<Photo>& photos, const std::filesystem::path& folder,
                      LinkedPhotos& linked);

}  // namespace tetrec
