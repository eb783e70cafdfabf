// Photos: the image files that a camera writes.
#pragma once

#include "image/color_profile.h"
#include "image/image.h"

#include <cstdint>
#include <filesystem>
#include <span>

namespace tetrec {

// ReadImage, with colours converted to display sRGB by the colour profile in the file, if there is
// one; `use` becomes what was done with it.
Image ReadPicture(const std::filesystem::path& path, ProfileUse& use,
                  ExifRotation rotation = ExifRotation::kIgnore,
                  uint64_t* clipped_pixels = nullptr);

// ReadImage for JPEG, PNG and TIFF only: an EXR is a DataError, too. `orientation` becomes the
// file's (exif.h), which is 1 for a PNG; the pixels are as stored whatever it is.
Image ReadPhoto(const std::filesystem::path& path, int* orientation = nullptr);

// True if the file that begins with `front` (26 bytes or more) is a PNG with 16 bits per sample and
// with colour or alpha. COLMAP cannot convert such a file to grey, because FreeImage cannot.
bool IsDeepColorPng(std::span<const uint8_t> front);

}  // namespace tetrec
