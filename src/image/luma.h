// Brightness of a colour.
#pragma once

#include <cstdint>

namespace tetrec {

// ITU-R BT.601, on display sRGB, in [0, 1].
inline float Luma(const uint8_t* rgb) {
  return (0.299f * float(rgb[0]) + 0.587f * float(rgb[1]) + 0.114f * float(rgb[2])) / 255.0f;
}

}  // namespace tetrec
