// OpenEXR headers, checked before OpenEXR reads them: it trusts their sizes.
#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <string>

namespace tetrec {

constexpr uint8_t kExrSignature[] = {0x76, 0x2f, 0x31, 0x01};

// Width and height of a file that starts with the signature. Throws DataError for several parts or
// deep pixels, attributes whose sizes do not fit their types, a file without an image channel,
// pixels (data window) that are not the whole image (display window), and chromaticities other than
// Rec. 709's (sRGB's, which OpenEXR also assumes if a file specifies none). Source: OpenEXR file
// layout, "Header".
glm::u64vec2 CheckExrHeader(std::span<const uint8_t> bytes, const std::string& name);

}  // namespace tetrec
