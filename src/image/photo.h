// Photos: the image files that a camera writes.
#pragma once

#include "image/image.h"

#include <cstdint>
#include <filesystem>
#include <span>

namespace tetrec {

// ReadImage for JPEG, PNG and TIFF only: an EXR is a DataError, too. `orientation` becomes the
// file's (exif.h), which is 1 for a PNG; the pixels are as stored whatever it is.
Image ReadPhoto(const std::filesystem::path& path, int* orientation = nullptr);

// Of a file's first 26 bytes or more: whether it is a PNG with colours or alpha of 16 bits per
// sample. FreeImage, and so COLMAP, does not turn one into grey.
bool IsDeepColorPng(std::span<const uint8_t> front);

}  // namespace tetrec
