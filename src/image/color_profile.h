// ICC colour profiles, which specify what the numbers of an image mean.
#pragma once

#include "image/image.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

enum class ProfileUse : uint8_t {
  kNone,     // no profile, or one that differs from sRGB by two levels at most
  kApplied,  // the image was converted
  kIgnored   // the profile is damaged, or not three primaries and their curves
};

// Converts an image from the colour space of the profile in its file (a JPEG, PNG or TIFF that
// DecodeImage has accepted) to display sRGB: relative to the white of each, black to black; colours
// outside of sRGB are clipped. Phones take photos in Display P3, for example. `name` is for
// messages.
ProfileUse ApplyColorProfile(std::span<const uint8_t> file, const std::string& name, Image& image);

// One line for all images whose profile was applied, and a warning for those whose profile was
// ignored.
void LogProfileUses(const std::vector<std::string>& names, const std::vector<ProfileUse>& uses);

}  // namespace tetrec
