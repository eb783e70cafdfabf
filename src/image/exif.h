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
  double focal_length_mm = 0;      // below kLongestFocalLength_mm
  uint16_t focal_length_35mm = 0;  // of a 35 mm camera with the same field of view [mm]
  // How many times larger a part of the sensor's picture is stored; 1: none is, or not known.
  double digital_zoom = 1;

  bool operator==(const CameraNotes&) const = default;
};

// What is not below it is taken for damage.
inline constexpr double kLongestFocalLength_mm = 1e5;

// The JPEG file with the notes as EXIF, in front of all that it contains. The digital zoom is left
// out, which COLMAP does not read.
std::vector<uint8_t> WithExif(std::span<const uint8_t> jpeg, const CameraNotes& notes);

// How the pixels of a JPEG are to be interpreted.
struct PixelNotes {
  // How the stored image must be turned or mirrored to be upright, from 1 (not at all) to 8.
  int orientation = 1;
  bool are_adobe_rgb = false;  // which cameras note instead of embedding a profile
};

// The notes in the content of a JPEG's APP1 segment; the defaults where the segment is not EXIF, is
// damaged, or contains no such note.
PixelNotes PixelNotesOfExif(std::span<const uint8_t> app1);

// The same for the camera's notes, of whose texts at most 100 bytes are read.
CameraNotes CameraNotesOfExif(std::span<const uint8_t> app1);

// The quarter turns clockwise, 0 to 3, by which the stored image must be turned so that what was up
// is at its top. What is stored as a mirror image remains one.
int QuarterTurnsOf(int orientation);

}  // namespace tetrec
