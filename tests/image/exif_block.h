// JPEG files with EXIF that gives an orientation.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tetrec {

// The content of an APP1 segment: a mark of 6 bytes, a header of 8, and from byte 14 a directory
// with one entry of 12 bytes, the orientation.
inline std::vector<uint8_t> ExifOfOrientation(uint32_t orientation, bool is_big_endian = false) {
  std::vector<uint8_t> bytes = {'E', 'x', 'i', 'f', 0, 0};
  const auto put = [&](uint32_t number, size_t size) {
    for (size_t i = 0; i < size; ++i) {
      bytes.push_back(uint8_t(number >> (8 * (is_big_endian ? size - 1 - i : i))));
    }
  };
  put(is_big_endian ? 0x4D4D : 0x4949, 2);  // MM or II
  put(42, 2);
  put(8, 4);  // where the directory is
  put(1, 2);  // its entries
  put(0x0112, 2);
  put(3, 2);  // a short
  put(1, 4);  // of them
  put(orientation, 2);
  put(0, 2);
  put(0, 4);  // no further directory
  return bytes;
}

// The JPEG with an APP1 segment after its start.
inline std::vector<uint8_t> WithApp1(std::vector<uint8_t> jpeg,
                                     const std::vector<uint8_t>& content) {
  std::vector<uint8_t> segment = {0xFF, 0xE1, uint8_t((content.size() + 2) >> 8),
                                  uint8_t(content.size() + 2)};
  segment.insert(segment.end(), content.begin(), content.end());
  jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  return jpeg;
}

}  // namespace tetrec
