// JPEG files, checked before OpenCV reads them: it passes on what libjpeg fills in for missing
// parts.
#pragma once

#include "image/exif.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

bool IsJpeg(std::span<const uint8_t> bytes);

// What a JPEG's markers specify, known before it is decoded.
struct JpegFacts {
  glm::u64vec2 size{0};  // of the largest frame [px]; 0 if there is none
  int scans = 0;
  PixelNotes notes;  // by EXIF
  CameraNotes camera;
  // The ICC profile, not checked; empty if one of its parts is missing or there twice.
  std::optional<std::vector<uint8_t>> color_profile;
};

// Walks the markers to the end of the image, which a search for the last such marker would not
// find, since thumbnails have one too. Throws DataError if there is none. Source: JPEG, ITU T.81,
// annex B.
JpegFacts ReadJpegMarkers(std::span<const uint8_t> bytes, const std::string& name);

// Decodes all scans, and throws DataError with libjpeg's words if any of them is damaged: libjpeg
// itself would only count a warning and fill the rest in grey. Damage that happens to decode to as
// many blocks as the image has cannot be noticed. Throws std::bad_alloc.
void CheckJpegScans(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec
