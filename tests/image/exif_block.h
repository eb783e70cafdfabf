// JPEG files with EXIF of their pixels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace tetrec {

// The content of an APP1 segment.
class ExifBlock {
 public:
  // A mark of 6 bytes and a header of 8.
  explicit ExifBlock(bool is_big_endian) : is_big_endian_(is_big_endian) {
    Put(is_big_endian ? 0x4D4D : 0x4949, 2);  // MM or II
    Put(42, 2);
    Put(8, 4);  // where the first directory is
  }

  void Put(uint32_t number, size_t size) {
    for (size_t i = 0; i < size; ++i) {
      bytes_.push_back(uint8_t(number >> (8 * (is_big_endian_ ? size - 1 - i : i))));
    }
  }

  // The front of an entry, whose value of four bytes comes next.
  void PutEntry(uint32_t tag, uint32_t type, uint32_t count) {
    Put(tag, 2);
    Put(type, 2);
    Put(count, 4);
  }

  // The place behind the next value and the end of its directory, where another one begins.
  void PutPlaceOfNext() { Put(uint32_t(bytes_.size()) - 6 + 8, 4); }

  // A first directory with one entry: the place of the directory that comes next.
  void PutPlaceOfDetails() {
    Put(1, 2);
    PutEntry(0x8769, 4, 1);  // a long
    PutPlaceOfNext();
    Put(0, 4);  // no further directory beside this one
  }

  const std::vector<uint8_t>& bytes() const { return bytes_; }

 private:
  bool is_big_endian_;
  std::vector<uint8_t> bytes_ = {'E', 'x', 'i', 'f', 0, 0};
};

// From byte 14 a directory with one entry of 12 bytes, the orientation.
inline std::vector<uint8_t> ExifOfOrientation(uint32_t orientation, bool is_big_endian = false) {
  ExifBlock exif(is_big_endian);
  exif.Put(1, 2);               // entries
  exif.PutEntry(0x0112, 3, 1);  // a short
  exif.Put(orientation, 2);
  exif.Put(0, 2);
  exif.Put(0, 4);  // no further directory
  return exif.bytes();
}

// From bytes 14, 32 and 62 directories: the place of the second one; the colour space and the place
// of the third one; the interoperability index, of three letters.
inline std::vector<uint8_t> ExifOfIndex(const std::string& index, bool is_big_endian = false,
                                        uint32_t color_space = 65535) {
  ExifBlock exif(is_big_endian);
  exif.PutPlaceOfDetails();
  exif.Put(2, 2);
  exif.PutEntry(0xA001, 3, 1);
  exif.Put(color_space, 2);
  exif.Put(0, 2);
  exif.PutEntry(0xA005, 4, 1);
  exif.PutPlaceOfNext();
  exif.Put(0, 4);
  exif.Put(1, 2);
  exif.PutEntry(1, 2, 4);  // text
  for (const char letter : index) exif.Put(uint8_t(letter), 1);
  exif.Put(0, 1);
  exif.Put(0, 4);
  return exif.bytes();
}

// From byte 14 a directory with one entry, whose value is the place of another one with one entry:
// the digital zoom, from byte 50.
inline std::vector<uint8_t> ExifOfDigitalZoom(uint32_t numerator, uint32_t denominator,
                                              bool is_big_endian = false) {
  ExifBlock exif(is_big_endian);
  exif.PutPlaceOfDetails();
  exif.Put(1, 2);
  exif.PutEntry(0xA404, 5, 1);  // a rational number
  exif.PutPlaceOfNext();
  exif.Put(0, 4);
  exif.Put(numerator, 4);
  exif.Put(denominator, 4);
  return exif.bytes();
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
