// Colour spaces of images, by ICC profiles, which specify what the numbers of an image mean, or by
// EXIF.
#pragma once

#include "image/image.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

enum class ProfileUse : uint8_t {
  kNone,     // no other space than sRGB is given, or one that differs by two levels at most
  kApplied,  // the image was converted
  kIgnored   // the profile is damaged, or not three primaries and their curves
};

// Converts an image from the colour space of the profile in its file (a JPEG, PNG or TIFF that
// DecodeImage has accepted) to display sRGB: relative to the white of each, black to black; colours
// outside of sRGB are clipped. Phones take photos in Display P3, for example. A JPEG without a
// profile is in Adobe RGB where its EXIF notes that. `name` is for messages.
ProfileUse ApplyColorProfile(std::span<const uint8_t> file, const std::string& name, Image& image);

// One line for all images that were converted, and a warning for those whose profile was
// ignored.
void LogProfileUses(const std::vector<std::string>& names, const std::vector<ProfileUse>& uses);

}  // namespace tetrec
