// EXIF: what a camera notes beside its pixels.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

// From which a photo's focal length in pixels can be derived; empty and 0: not known.
struct CameraNotes {
  std::string make, model;
  double focal_length_mm = 0;
  uint16_t focal_length_35mm = 0;  // of a 35 mm camera with the same field of view [mm]
};

// The JPEG file with the notes as EXIF, in front of all that it contains.
std::vector<uint8_t> WithExif(std::span<const uint8_t> jpeg, const CameraNotes& notes);

}  // namespace tetrec
