// PNG files, checked before OpenCV reads them, because OpenCV takes a truncated file for a complete
// one.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

bool IsPng(std::span<const uint8_t> bytes);

// What a PNG's chunks specify, known before it is decoded.
struct PngFacts {
  bool has_transparency_chunk = false;
  std::optional<std::span<const uint8_t>> color_profile;  // the content of the iCCP chunk
};

// Walks the chunks to the end of the image. Throws DataError if there is none, or if the image is
// too large. Source: PNG, ISO 15948, section 5.
PngFacts ReadPngChunks(std::span<const uint8_t> bytes, const std::string& name);

// The ICC profile, not checked; empty if it is damaged or longer than 4 MiB.
std::optional<std::vector<uint8_t>> ColorProfileOfPng(std::span<const uint8_t> bytes,
                                                      const std::string& name);

}  // namespace tetrec
