// TIFF files by libtiff.
#pragma once

#include "image/exif.h"
#include "image/image.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

bool IsTiff(std::span<const uint8_t> bytes);

// The first page, with its pixels as stored, whatever orientation the file gives. 16 bits are
// rounded to 8. Throws DataError (damaged, too large, samples that are not unsigned integers of at
// most 16 bits).
Image DecodeTiff(std::span<const uint8_t> bytes, const std::string& name);

// As far as the file has them.
CameraNotes CameraNotesOfTiff(std::span<const uint8_t> bytes, const std::string& name);

// The ICC profile of the first page, not checked.
std::optional<std::vector<uint8_t>> ColorProfileOfTiff(std::span<const uint8_t> bytes,
                                                       const std::string& name);

// The orientation (exif.h) of the first page; 1 if it gives none from 1 to 8.
int OrientationOfTiff(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec
