// Photos: the image files that a camera writes.
#pragma once

#include "image/image.h"

#include <filesystem>

namespace tetrec {

// ReadImage for JPEG and PNG only: an EXR is a DataError, too.
Image ReadPhoto(const std::filesystem::path& path);

}  // namespace tetrec
