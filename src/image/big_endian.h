// Integers in big-endian byte order, as PNG and JPEG files contain them.
#pragma once

#include <cstdint>

namespace tetrec {

inline uint32_t BigEndian16(const uint8_t* p) { return uint32_t(p[0]) << 8 | p[1]; }
inline uint32_t BigEndian32(const uint8_t* p) { return BigEndian16(p) << 16 | BigEndian16(p + 2); }

}  // namespace tetrec
