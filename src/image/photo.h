// Photos: the image files that a camera writes.
#pragma once

#include "image/color_profile.h"
#include "image/exif.h"
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

// What a photo's file notes beside its pixels; the defaults for a PNG.
struct PhotoNotes {
  int orientation = 1;  // exif.h; the pixels are as stored whatever it is
  CameraNotes camera;
};

// ReadImage for JPEG, PNG and TIFF only: an EXR is a DataError, too.
Image ReadPhoto(const std::filesystem::path& path, PhotoNotes* notes = nullptr);

// True if the file that begins with `front` (26 bytes or more) is a PNG with 16 bits per sample and
// with colour or alpha. COLMAP cannot convert such a file to grey, because FreeImage cannot.
bool IsDeepColorPng(std::span<const uint8_t> front);

}  // namespace tetrec
