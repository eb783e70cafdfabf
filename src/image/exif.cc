// EXIF: what a camera notes beside its pixels.
#include "image/exif.h"

#include "core/error.h"
#include "core/file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string_view>

namespace tetrec {
namespace {

// Types of values, and their tags. (Exif 2.32, section 4.6)
constexpr uint16_t kAscii = 2, kShort = 3, kLong = 4, kRational = 5;
constexpr uint16_t kMake = 0x010F, kModel = 0x0110, kOrientation = 0x0112, kExifDirectory = 0x8769,
                   kFocalLength = 0x920A, kColorSpace = 0xA001, kInteroperability = 0xA005,
                   kDigitalZoom = 0xA404, kFocalLength35 = 0xA405;
constexpr uint16_t kInteroperabilityIndex = 1;  // in the directory of that name
constexpr size_t kEntryBytes = 12;
constexpr std::string_view kExifMark("Exif\0\0", 6);  // in front of EXIF in a JPEG's segment
constexpr size_t kMostText = 100;

void WriteEntry(ByteWriter& to, uint16_t tag, uint16_t type, size_t count, size_t value) {
  to.Write(tag);
  to.Write(type);
  to.Write(uint32_t(count));
  to.Write(uint32_t(value));
}

constexpr size_t DirectoryBytes(size_t entries) { return 2 + kEntryBytes * entries + 4; }

// A text of EXIF: of limited length, ended by a zero and never shorter than what an entry contains
// itself, so that it always has a place of its own.
std::string Text(const std::string& text) {
  std::string padded = text.substr(0, kMostText);
  padded.resize(std::max(padded.size() + 1, size_t(6)), '\0');
  return padded;
}

// A TIFF file without pixels: a directory with the camera's name, one with the focal lengths, and
// the values that are longer than four bytes.
std::vector<uint8_t> ExifOf(const CameraNotes& notes) {
  constexpr size_t kFirst = 8, kSecond = kFirst + DirectoryBytes(3),
                   kValues = kSecond + DirectoryBytes(2);
  const std::string make = Text(notes.make), model = Text(notes.model);
  ByteWriter exif;
  exif.WriteArray<char>(std::string("II*\0", 4));
  exif.Write(uint32_t(kFirst));
  exif.Write(uint16_t(3));
  WriteEntry(exif, kMake, kAscii, make.size(), kValues);
  WriteEntry(exif, kModel, kAscii, model.size(), kValues + make.size());
  WriteEntry(exif, kExifDirectory, kLong, 1, kSecond);
  exif.Write(uint32_t(0));
  exif.Write(uint16_t(2));
  WriteEntry(exif, kFocalLength, kRational, 1, kValues + make.size() + model.size());
  WriteEntry(exif, kFocalLength35, kShort, 1, notes.focal_length_35mm);
  exif.Write(uint32_t(0));
  exif.WriteArray<char>(make);
  exif.WriteArray<char>(model);
  exif.Write(uint32_t(std::lround(notes.focal_length_mm * 1000)));
  exif.Write(uint32_t(1000));
  return exif.bytes();
}

// The integers of a TIFF structure in the byte order that it has. Beyond its end, where the places
// that a damaged one gives may be, they are 0.
struct TiffStructure {
  std::span<const uint8_t> bytes;
  bool is_big_endian = false;

  uint32_t At(size_t position, size_t size) const {
    if (position > bytes.size() || size > bytes.size() - position) return 0;
    uint32_t value = 0;
    for (size_t i = 0; i < size; ++i) {
      value = value << 8 | bytes[position + (is_big_endian ? i : size - 1 - i)];
    }
    return value;
  }

  // The place of a directory's entry; 0 if there is none of this type.
  size_t FindEntry(size_t directory, uint16_t tag, uint16_t type) const {
    // No more than fit, so that a hostile file of many such segments takes no time.
    const size_t entries = std::min<size_t>(At(directory, 2), bytes.size() / kEntryBytes);
    for (size_t i = 0; i < entries; ++i) {
      const size_t entry = directory + 2 + kEntryBytes * i;
      if (At(entry, 2) != tag) continue;
      return At(entry + 2, 2) == type ? entry : 0;
    }
    return 0;
  }

  // The place of the value of an entry; 0 if there is none with this type and count.
  size_t Find(size_t directory, uint16_t tag, uint16_t type, size_t count) const {
    const size_t entry = FindEntry(directory, tag, type);
    return entry > 0 && At(entry + 4, 4) == count ? entry + 8 : 0;
  }

  // The directory whose place is the value of an entry; 0 if there is none.
  size_t InnerDirectory(size_t outer, uint16_t tag) const {
    const size_t place = outer > 0 ? Find(outer, tag, kLong, 1) : 0;
    return place > 0 ? At(place, 4) : 0;
  }

  // Up to its first zero; empty if there is none.
  std::string TextOf(size_t directory, uint16_t tag) const {
    const size_t entry = FindEntry(directory, tag, kAscii);
    if (entry == 0) return "";
    const size_t count = At(entry + 4, 4), place = count > 4 ? At(entry + 8, 4) : entry + 8;
    if (place == 0 || place > bytes.size()) return "";
    const std::span<const uint8_t> text =
        bytes.subspan(place, std::min({count, bytes.size() - place, kMostText}));
    return {text.begin(), std::find(text.begin(), text.end(), uint8_t(0))};
  }

  // 0 if there is none.
  double RationalOf(size_t directory, uint16_t tag) const {
    const size_t entry = Find(directory, tag, kRational, 1);
    const size_t place = entry > 0 ? At(entry, 4) : 0;
    const uint32_t denominator = place > 0 ? At(place + 4, 4) : 0;
    return denominator > 0 ? double(At(place, 4)) / denominator : 0;
  }
};

// Returns the TIFF structure in the content of a JPEG's APP1 segment; it is empty if the segment is
// not EXIF.
TiffStructure StructureIn(std::span<const uint8_t> app1) {
  const std::string_view text(reinterpret_cast<const char*>(app1.data()), app1.size());
  if (!text.starts_with(kExifMark)) return {};
  const std::string_view signature = text.substr(kExifMark.size(), 4);
  const bool is_big_endian = signature == std::string_view("MM\0*", 4);
  if (!is_big_endian && signature != std::string_view("II*\0", 4)) return {};
  return {app1.subspan(kExifMark.size()), is_big_endian};
}

// Only the first directory counts: the second one is about the thumbnail.
size_t FirstDirectory(const TiffStructure& exif) { return exif.At(4, 4); }

int OrientationIn(const TiffStructure& exif, size_t directory) {
  const size_t place = exif.Find(directory, kOrientation, kShort, 1);
  const uint32_t orientation = place > 0 ? exif.At(place, 2) : 1;
  return orientation >= 1 && orientation <= 8 ? int(orientation) : 1;
}

// By the index of the DCF's optional files, which are all in Adobe RGB (DCF 2.0, section 3.2),
// unless a program has converted the image since and noted sRGB.
bool IsAdobeRgb(const TiffStructure& exif, size_t directory) {
  constexpr uint32_t kSrgb = 1;
  const size_t details = exif.InnerDirectory(directory, kExifDirectory);
  const size_t space = details > 0 ? exif.Find(details, kColorSpace, kShort, 1) : 0;
  if (space > 0 && exif.At(space, 2) == kSrgb) return false;
  const size_t notes = exif.InnerDirectory(details, kInteroperability);
  const size_t index = notes > 0 ? exif.Find(notes, kInteroperabilityIndex, kAscii, 4) : 0;
  return index > 0 && index + 4 <= exif.bytes.size() &&
         std::memcmp(&exif.bytes[index], "R03", 4) == 0;
}

}  // namespace

std::vector<uint8_t> WithExif(std::span<const uint8_t> jpeg, const CameraNotes& notes) {
  TETREC_CHECK(jpeg.size() > 2 && jpeg[0] == 0xFF && jpeg[1] == 0xD8, "not a JPEG file");
  const std::vector<uint8_t> exif = ExifOf(notes);
  const size_t length = 2 + kExifMark.size() + exif.size();
  ByteWriter with;
  with.WriteArray(jpeg.first(2));
  const std::array marker = {uint8_t(0xFF), uint8_t(0xE1), uint8_t(length >> 8), uint8_t(length)};
  with.WriteArray<uint8_t>(marker);
  with.WriteArray<char>(kExifMark);
  with.WriteArray<uint8_t>(exif);
  with.WriteArray(jpeg.subspan(2));
  return with.bytes();
}

PixelNotes PixelNotesOfExif(std::span<const uint8_t> app1) {
  const TiffStructure exif = StructureIn(app1);
  const size_t directory = FirstDirectory(exif);
  return {OrientationIn(exif, directory), IsAdobeRgb(exif, directory)};
}

CameraNotes CameraNotesOfExif(std::span<const uint8_t> app1) {
  const TiffStructure exif = StructureIn(app1);
  const size_t directory = FirstDirectory(exif);
  CameraNotes notes;
  notes.make = exif.TextOf(directory, kMake);
  notes.model = exif.TextOf(directory, kModel);
  const size_t inner = exif.InnerDirectory(directory, kExifDirectory);
  if (inner == 0) return notes;
  const double focal_length_mm = exif.RationalOf(inner, kFocalLength);
  if (focal_length_mm < kLongestFocalLength_mm) notes.focal_length_mm = focal_length_mm;
  const size_t equivalent = exif.Find(inner, kFocalLength35, kShort, 1);
  if (equivalent > 0) notes.focal_length_35mm = uint16_t(exif.At(equivalent, 2));
  notes.digital_zoom = std::max(1.0, exif.RationalOf(inner, kDigitalZoom));
  return notes;
}

int QuarterTurnsOf(int orientation) {
  switch (orientation) {
    case 3:
    case 4:
      return 2;  // the upright image's top is the last row
    case 5:
    case 6:
      return 1;  // the first column
    case 7:
    case 8:
      return 3;  // the last column
    default:
      return 0;  // the first row
  }
}

}  // namespace tetrec
