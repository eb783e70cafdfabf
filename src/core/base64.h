// Bytes as text.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace tetrec {

// RFC 4648, with padding and without line breaks.
std::string Base64(std::span<const uint8_t> bytes);

}  // namespace tetrec
