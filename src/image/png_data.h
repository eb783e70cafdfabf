// PNG files, checked before OpenCV reads them: it takes a truncated file for a complete one.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace tetrec {

bool IsPng(std::span<const uint8_t> bytes);

// What a PNG's chunks specify, known before it is decoded.
struct PngFacts {
  bool has_transparency_chunk = false;
  std::span<const uint8_t> color_profile;  // the content of the iCCP chunk; empty: there is none
};

// Walks the chunks to the end of the image. Throws DataError if there is none, or if the image is
// too large. Source: PNG, ISO 15948, section 5.
PngFacts ReadPngChunks(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec
