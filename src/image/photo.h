// Photos: the image files that a camera writes.
#pragma once

#include "image/image.h"

#include <filesystem>

namespace tetrec {

// ReadImage for JPEG, PNG and TIFF only: an EXR is a DataError, too. `orientation` becomes the
// file's (exif.h), which is 1 for a PNG; the pixels are as stored whatever it is.
Image ReadPhoto(const std::filesystem::path& path, int* orientation = nullptr);

}  // namespace tetrec
