// ICC colour profiles, which specify what the numbers of an image mean.
#pragma once

#include "image/image.h"

#include <cstdint>
#include <span>
#include <string>

namespace tetrec {

// Converts an image from the colour space of the profile in its file (a JPEG, PNG or TIFF that
// DecodeImage has accepted) to display sRGB: relative to the white of each, black to black; what is
// outside of sRGB is clipped. Phones take photos in Display P3, for example. An image without a
// profile, or with one that differs from sRGB by two levels at most, stays as it is; so does one
// whose profile is damaged or not of RGB, with a warning that contains `name`.
void ApplyColorProfile(std::span<const uint8_t> file, const std::string& name, Image& image);

}  // namespace tetrec
