// The photos of a folder.
#pragma once

#include "image/exif.h"

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// With two photos, each point is seen in two of them, too few for JudgeModel.
inline constexpr size_t kFewestPhotos = 3;

struct Photo {
  std::string name;                  // relative to the folder, generic form
  std::filesystem::path file;        // its pixels: itself, or a JPEG file made of it
  std::filesystem::path for_colmap;  // the same, as JPEG or PNG
  int width = 0, height = 0;
  int quarter_turns = 0;         // clockwise, that make it upright, by its EXIF
  CameraNotes camera;            // by its EXIF
  std::string sha256;            // of what COLMAP reads
  std::filesystem::path mask;    // empty: all of it is used
  bool mask_is_upright = false;  // it has to be turned back to fit the stored photo
  std::string mask_sha256;
};

struct PhotoFolder {
  std::vector<Photo> photos;            // sorted by name
  std::vector<std::string> unreadable;  // names of those that cannot be read
};

// JPEG, PNG, TIFF and HEIC files in the folder and below, by their extensions and then by what they
// contain; hidden files are ignored. Each is decoded once; one warning names all that cannot be
// read, and another those that are exact copies of others. TIFF, HEIC and coloured PNG of 16 bits,
// which COLMAP cannot read, become JPEG files in the folder `converted`, where those of an earlier
// call are used again. Throws DataError if the unreadable are more than `max_unreadable` of all
// files, for fewer than 3 photos, and for names that cannot be stored (StaysInside). `masks` may be
// a folder inside, whose images are no photos, or empty. Folders such as images_4 beside images are
// left out. Warns of known cameras that are not read.
PhotoFolder FindPhotos(const std::filesystem::path& folder, double max_unreadable,
                       const std::filesystem::path& converted,
                       const std::filesystem::path& masks = {});

}  // namespace tetrec
