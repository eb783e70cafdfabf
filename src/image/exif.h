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

// The orientation specifies how a stored image must be turned or mirrored to be upright, from 1
// (not at all) to 8. This is that of the content of a JPEG's APP1 segment; 1 if the segment is not
// EXIF, is damaged, or contains no such number.
int OrientationOfExif(std::span<const uint8_t> app1);

// The quarter turns clockwise, 0 to 3, by which the stored image must be turned so that what was up
// is at its top. What is stored as a mirror image remains one.
int QuarterTurnsOf(int orientation);

}  // namespace tetrec
