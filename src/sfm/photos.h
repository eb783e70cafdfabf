// The photos of a folder.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

struct Photo {
  std::string name;  // relative to the folder, generic form
  int width = 0, height = 0;
  std::string sha256;
  std::filesystem::path mask;  // empty: all of it is used
  std::string mask_sha256;
};

struct PhotoFolder {
  std::vector<Photo> photos;            // sorted by name
  std::vector<std::string> unreadable;  // names of those that were left out
};

// JPEG and PNG files in the folder and below; hidden files are ignored. Each is decoded once, and
// one warning names all that cannot be read. Throws DataError if these are more than
// `max_unreadable` of all files, for fewer than 2 files, and for names that cannot be stored
// (StaysInside). `masks` may be a folder inside, whose images are no photos, or empty.
PhotoFolder FindPhotos(const std::filesystem::path& folder, double max_unreadable,
                       const std::filesystem::path& masks = {});

}  // namespace tetrec
