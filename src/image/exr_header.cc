// OpenEXR headers, checked before OpenEXR reads them.
#include "image/exr_header.h"

#include "core/error.h"
#include "core/file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <map>
#include <optional>

namespace tetrec {
namespace {

// Size of a value in bytes, by its type. Values of other types have the size that the file states.
const std::map<std::string, size_t> kSizes = {
    {"box2f", 16},      {"box2i", 16},   {"chromaticities", 32},
    {"compression", 1}, {"double", 8},   {"envmap", 1},
    {"float", 4},       {"int", 4},      {"keycode", 28},
    {"lineOrder", 1},   {"m33d", 72},    {"m33f", 36},
    {"m44d", 128},      {"m44f", 64},    {"rational", 8},
    {"tiledesc", 9},    {"timecode", 8}, {"v2d", 16},
    {"v2f", 8},         {"v2i", 8},      {"v3d", 24},
    {"v3f", 12},        {"v3i", 12},     {"deepImageState", 1}};

// Reads to the terminating 0 and past it.
std::string ReadName(ByteReader& reader) {
  constexpr size_t kLongestName = 255;
  std::string text;
  while (const char c = reader.Read<char>("a name in the EXR header")) {
    if (text.size() == kLongestName) {
      throw DataError(fmt::format("{}: EXR header with a name that is too long", reader.name()));
    }
    text += c;
  }
  return text;
}

// Reads channels until an empty name, which must end the value. One of them must belong to an
// image; depth alone and layers, whose names contain a dot, do not count.
void CheckChannels(std::span<const uint8_t> value, const std::string& name) {
  ByteReader reader(value, name + ": EXR channels");
  bool is_image = false;
  for (std::string channel; !(channel = ReadName(reader)).empty();) {
    reader.Read<std::array<uint8_t, 16>>("a channel");
    is_image |= channel == "R" || channel == "G" || channel == "B" || channel == "Y";
  }
  reader.ExpectEnd();
  if (is_image) return;
  throw DataError(fmt::format(
      "{}: EXR without a channel R, G, B or Y; store the image under these names", name));
}

// A preview has 4 bytes per pixel.
void CheckPreview(std::span<const uint8_t> value, const std::string& name) {
  ByteReader reader(value, name + ": EXR preview");
  const uint64_t width = reader.Read<uint32_t>("its width"),
                 height = reader.Read<uint32_t>("height");
  reader.ReadArray<uint32_t>(width * height, "pixels");
  reader.ExpectEnd();
}

// A list of texts, each behind its size.
void CheckTexts(std::span<const uint8_t> value, const std::string& name) {
  ByteReader reader(value, name + ": EXR texts");
  while (reader.remaining() > 0) {
    reader.ReadArray<char>(reader.Read<uint32_t>("a text's size"), "bytes of a text");
  }
}

void CheckValue(const std::string& attribute, const std::string& type,
                std::span<const uint8_t> value, const std::string& name) {
  if (type == "chlist") CheckChannels(value, name);
  if (type == "preview") CheckPreview(value, name);
  if (type == "stringvector") CheckTexts(value, name);
  const auto known = kSizes.find(type);
  if (known == kSizes.end() || known->second == value.size()) return;
  throw DataError(fmt::format("{}: EXR attribute {} of {} bytes; expected {}", name, attribute,
                              value.size(), known->second));
}

// x and y of red, green, blue and white.
using Chromaticities = std::array<float, 8>;

// Rec. 709's and sRGB's. Source: ITU-R BT.709, "reference primaries".
constexpr Chromaticities kRec709 = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};

// Values for other primaries would be accepted as these, with every colour slightly wrong.
void CheckChromaticities(std::span<const uint8_t> value, const std::string& name) {
  constexpr float kTolerance = 1e-3f;
  const auto found = ByteReader(value, name).Read<Chromaticities>("EXR chromaticities");
  for (size_t i = 0; i < found.size(); ++i) {
    if (std::abs(found[i] - kRec709[i]) <= kTolerance) continue;
    throw DataError(fmt::format(
        "{}: EXR with chromaticities red ({}, {}), green ({}, {}), blue ({}, {}), white ({}, {}), "
        "which are not those of Rec. 709; convert it to linear Rec. 709 (sRGB primaries)",
        name, found[0], found[1], found[2], found[3], found[4], found[5], found[6], found[7]));
  }
}

// Corners x0 y0 x1 y1, both inside.
using Window = std::array<int32_t, 4>;

Window WindowOf(std::span<const uint8_t> value, const std::string& name) {
  return ByteReader(value, name).Read<Window>("an EXR window");
}

uint64_t Side(int32_t first, int32_t last) {
  return last < first ? 0 : uint64_t(int64_t(last) - first + 1);
}

}  // namespace

glm::u64vec2 CheckExrHeader(std::span<const uint8_t> bytes, const std::string& name) {
  ByteReader reader(bytes, name);
  reader.Read<uint32_t>("EXR signature");
  constexpr uint32_t kVersionAndPlainFlags = 0x2 | 0x200 | 0x400;  // tiles, long names
  if ((reader.Read<uint32_t>("EXR flags") & ~kVersionAndPlainFlags) != 0) {
    throw DataError(
        fmt::format("{}: EXR with several parts or deep pixels; store it as one plain part", name));
  }
  std::optional<Window> data, display;
  for (std::string attribute; !(attribute = ReadName(reader)).empty();) {
    const std::string type = ReadName(reader);
    const auto value = reader.ReadArray<uint8_t>(reader.Read<uint32_t>("an EXR attribute's size"),
                                                 "bytes of an EXR attribute");
    CheckValue(attribute, type, value, name);
    if (attribute == "chromaticities" && type == attribute) CheckChromaticities(value, name);
    if (attribute == "dataWindow") data = WindowOf(value, name);
    if (attribute == "displayWindow") display = WindowOf(value, name);
  }
  if (!data || !display) throw DataError(fmt::format("{}: EXR header without a window", name));
  if (data != display) {
    throw DataError(fmt::format(
        "{}: EXR whose pixels (data window) are not exactly the image (display window); "
        "store the whole image",
        name));
  }
  return {Side((*data)[0], (*data)[2]), Side((*data)[1], (*data)[3])};
}

}  // namespace tetrec
