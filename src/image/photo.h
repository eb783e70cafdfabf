// Photos: the image files that a camera writes.
#pragma once

#include "image/image.h"

#include <cstdint>
#include <filesystem>
#include <span>

namespace tetrec {

// ReadImage, with colours converted to display sRGB from the colour profile in the file, if it has
// one (color_profile.h).
Image ReadPicture(const std::filesystem::path& path, ExifRotation rotation = ExifRotation::kIgnore,
                  uint64_t* clipped_pixels = nullptr);

// ReadPicture for JPEG, PNG and TIFF only: an EXR is a DataError, too. `orientation` becomes the
// file's (exif.h), which is 1 for a PNG; the pixels are as stored whatever it is.
Image ReadPhoto(const std::filesystem::path& path, int* orientation = nullptr);

// True if the file that begins with `front` (26 bytes or more) is a PNG with 16 bits per sample and
// with colour or alpha. COLMAP cannot convert such a file to grey, because FreeImage cannot.
bool IsDeepColorPng(std::span<const uint8_t> front);

}  // namespace tetrec
