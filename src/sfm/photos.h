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
};

// JPEG and PNG files in the folder and below, sorted by name; hidden files are ignored. Each is
// decoded once, and one DataError names all that cannot be read. Throws DataError for fewer than 2,
// and for names that cannot be stored (StaysInside).
std::vector<Photo> FindPhotos(const std::filesystem::path& folder);

}  // namespace tetrec
