// Photos: the image files that a camera writes.
#pragma once

#include "image/image.h"

#include <filesystem>

namespace tetrec {

// ReadImage for JPEG, PNG and TIFF only: an EXR is a DataError, too.
Image ReadPhoto(const std::filesystem::path& path);

}  // namespace tetrec
