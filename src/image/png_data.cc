// Chunks of PNG files.
#include "image/png_data.h"

#include "core/error.h"
#include "image/big_endian.h"
#include "image/size_limits.h"
#include "image/starts_with.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <string_view>

namespace tetrec {
namespace {

constexpr uint8_t kPngSignature[] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

// Bits per pixel for the bit depth and colour type of the header chunk.
uint64_t PngBits(uint8_t depth, uint8_t color_type) {
  const bool has_colours = (color_type & 3) == 2, has_alpha = (color_type & 4) != 0;
  return uint64_t(depth) * ((has_colours ? 3 : 1) + (has_alpha ? 1 : 0));
}

// Empty if the data is damaged or too long.
std::vector<uint8_t> Inflated(std::span<const uint8_t> data) {
  std::vector<uint8_t> profile(kMostColorProfile_bytes);
  uLongf size = profile.size();
  if (uncompress(profile.data(), &size, data.data(), uLong(data.size())) != Z_OK) size = 0;
  profile.resize(size);
  return profile;
}

}  // namespace

bool IsPng(std::span<const uint8_t> bytes) { return StartsWith(bytes, kPngSignature); }

PngFacts ReadPngChunks(std::span<const uint8_t> bytes, const std::string& name) {
  PngFacts facts;
  size_t position = sizeof(kPngSignature);
  bool header_seen = false;
  while (bytes.size() - position >= 12) {
    const uint64_t length = BigEndian32(&bytes[position]);
    const uint8_t* content = &bytes[position + 8];
    if (length > bytes.size() - position - 12) break;
    const std::string_view type(reinterpret_cast<const char*>(content) - 4, 4);
    if (type == "IHDR" && length >= 10) {
      const uint64_t width = BigEndian32(content), height = BigEndian32(content + 4);
      CheckSize(width, height, name);
      CheckAgainstFile(width * height * PngBits(content[8], content[9]) / 8, bytes.size(), name);
      header_seen = true;
    }
    if (!header_seen) throw DataError(fmt::format("{}: PNG file without a header chunk", name));
    if (type == "tRNS") facts.has_transparency_chunk = true;
    if (type == "iCCP") facts.color_profile.emplace(content, size_t(length));
    if (type == "IEND") return facts;
    position += 12 + length;
  }
  throw DataError(fmt::format(
      "{}: truncated image, ends after {} bytes; copy it again or remove it", name, bytes.size()));
}

std::optional<std::vector<uint8_t>> ColorProfileOfPng(std::span<const uint8_t> bytes,
                                                      const std::string& name) {
  const auto chunk = ReadPngChunks(bytes, name).color_profile;
  if (!chunk) return std::nullopt;
  // A name, a zero, the method of compression (0), and the profile (section 11.3.3.3).
  const auto zero = size_t(std::ranges::find(*chunk, uint8_t(0)) - chunk->begin());
  return chunk->size() < zero + 2 ? std::vector<uint8_t>() : Inflated(chunk->subspan(zero + 2));
}

}  // namespace tetrec
