// Markers and scans of JPEG files.
#include "image/jpeg_data.h"

#include "core/error.h"
#include "image/big_endian.h"
#include "image/starts_with.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdio>
#include <new>

// These need <cstdio>.
#include <jerror.h>
#include <jpeglib.h>

#include <algorithm>
#include <array>
#include <csetjmp>
#include <cstring>
#include <map>
#include <set>
#include <string_view>

namespace tetrec {
namespace {

// Position behind the two bytes of the next marker, 0 if there is none. Skips byte stuffing, fill
// bytes and restart markers.
size_t NextMarker(std::span<const uint8_t> bytes, size_t position) {
  for (; position + 1 < bytes.size(); ++position) {
    const uint8_t code = bytes[position + 1];
    const bool is_marker = code != 0x00 && code != 0xFF && (code < 0xD0 || code > 0xD7);
    if (bytes[position] == 0xFF && is_marker) return position + 2;
  }
  return 0;
}

// The parts of an ICC profile, by their numbers, which writers may store in any order.
struct ProfileParts {
  std::map<uint8_t, std::span<const uint8_t>> parts;
  std::set<uint8_t> counts;  // of all parts, as each part gives it
  bool is_damaged = false;

  // An APP2 segment that begins with this mark has the number of the part, from 1, then that of all
  // parts, and its content. Source: ICC.1:2010, annex B.4.
  void Add(std::span<const uint8_t> segment) {
    constexpr std::string_view kMark("ICC_PROFILE\0", 12);
    constexpr size_t kFront = kMark.size() + 2;
    if (segment.size() < kFront) return;
    if (std::memcmp(segment.data(), kMark.data(), kMark.size()) != 0) return;
    counts.insert(segment[kMark.size() + 1]);
    if (!parts.emplace(segment[kMark.size()], segment.subspan(kFront)).second) is_damaged = true;
  }

  std::optional<std::vector<uint8_t>> Join() const {
    if (parts.empty()) return std::nullopt;
    std::vector<uint8_t> joined;
    const bool is_whole = !is_damaged && counts.size() == 1 && parts.size() == *counts.begin() &&
                          parts.begin()->first == 1 && parts.rbegin()->first == parts.size();
    if (!is_whole) return joined;
    for (const auto& [number, part] : parts) joined.insert(joined.end(), part.begin(), part.end());
    return joined;
  }
};

// libjpeg's reports. It takes a pointer to the first member for one to the whole.
struct Reports {
  jpeg_error_mgr manager;
  std::jmp_buf after_failure;
  std::array<char, JMSG_LENGTH_MAX> first = {};  // in words; empty: there is none
  bool are_read = false;                         // warnings are kept
};

void Keep(j_common_ptr decoder) {
  auto* reports = reinterpret_cast<Reports*>(decoder->err);
  if (reports->first[0] == 0) (*decoder->err->format_message)(decoder, reports->first.data());
}

[[noreturn]] void Fail(j_common_ptr decoder) {
  Keep(decoder);
  std::longjmp(reinterpret_cast<Reports*>(decoder->err)->after_failure, 1);
}

// Cameras pad their scans with a few bytes. Damage leaves more behind.
bool IsPadding(const jpeg_error_mgr& report) {
  constexpr int kMostPadding_bytes = 64;
  return report.msg_code == JWRN_EXTRANEOUS_DATA && report.msg_parm.i[0] <= kMostPadding_bytes;
}

void Warn(j_common_ptr decoder, int level) {
  const auto* reports = reinterpret_cast<const Reports*>(decoder->err);
  if (level < 0 && reports->are_read && !IsPadding(reports->manager)) Keep(decoder);
}

// An eighth of the size has all of the scans' codes decoded, and the least of the rest done.
// Warnings about the header are common and harmless. Nothing here has a destructor, which `Fail`
// would skip.
void DecodeScans(jpeg_decompress_struct& decoder, Reports& reports, std::span<const uint8_t> bytes,
                 std::vector<uint8_t>& row) {
  if (setjmp(reports.after_failure) != 0) return;
  jpeg_create_decompress(&decoder);
  jpeg_mem_src(&decoder, bytes.data(), bytes.size());
  jpeg_read_header(&decoder, TRUE);
  reports.are_read = true;
  decoder.scale_num = 1;
  decoder.scale_denom = 8;
  decoder.dct_method = JDCT_IFAST;
  decoder.do_fancy_upsampling = FALSE;
  decoder.out_color_space = decoder.jpeg_color_space;
  jpeg_start_decompress(&decoder);
  row.resize(size_t(decoder.output_width) * size_t(decoder.output_components));
  uint8_t* const start = row.data();
  while (decoder.output_scanline < decoder.output_height) {
    JSAMPROW rows[] = {start};
    jpeg_read_scanlines(&decoder, rows, 1);
  }
  jpeg_finish_decompress(&decoder);
}

}  // namespace

bool IsJpeg(std::span<const uint8_t> bytes) {
  constexpr uint8_t kSignature[] = {0xFF, 0xD8, 0xFF};
  return StartsWith(bytes, kSignature);
}

JpegFacts ReadJpegMarkers(std::span<const uint8_t> bytes, const std::string& name) {
  JpegFacts facts;
  ProfileParts profile;
  size_t position = 2;
  while ((position = NextMarker(bytes, position)) != 0) {
    const uint8_t code = bytes[position - 1];
    if (code == 0xD9) {  // EOI
      facts.color_profile = profile.Join();
      return facts;
    }
    if (code == 0x01 || code == 0xD8) continue;  // markers without a segment
    if (bytes.size() - position < 2) break;
    const size_t length = BigEndian16(&bytes[position]);
    if (length > bytes.size() - position) break;
    const bool is_frame =
        code >= 0xC0 && code <= 0xCF && code != 0xC4 && code != 0xC8 && code != 0xCC;
    if (is_frame && length >= 7) {
      facts.size = glm::max(facts.size,
                            {BigEndian16(&bytes[position + 5]), BigEndian16(&bytes[position + 3])});
    }
    // Other things than EXIF have such segments (APP1), too.
    if (code == 0xE1 && length > 2) {
      const std::span<const uint8_t> content = bytes.subspan(position + 2, length - 2);
      const PixelNotes notes = PixelNotesOfExif(content);
      if (facts.notes.orientation == 1) facts.notes.orientation = notes.orientation;
      if (notes.are_adobe_rgb) facts.notes.are_adobe_rgb = true;
      if (facts.camera == CameraNotes{}) facts.camera = CameraNotesOfExif(content);
    }
    if (code == 0xE2 && length > 2) profile.Add(bytes.subspan(position + 2, length - 2));
    if (code == 0xDA) ++facts.scans;
    position += length;
  }
  throw DataError(fmt::format(
      "{}: truncated image, ends after {} bytes; copy it again or remove it", name, bytes.size()));
}

void CheckJpegScans(std::span<const uint8_t> bytes, const std::string& name) {
  Reports reports;
  jpeg_decompress_struct decoder = {};
  decoder.err = jpeg_std_error(&reports.manager);
  reports.manager.error_exit = Fail;
  reports.manager.emit_message = Warn;
  std::vector<uint8_t> row;
  DecodeScans(decoder, reports, bytes, row);
  const bool is_out_of_memory = reports.manager.msg_code == JERR_OUT_OF_MEMORY;
  jpeg_destroy_decompress(&decoder);
  if (is_out_of_memory) throw std::bad_alloc();
  if (reports.first[0] != 0) {
    throw DataError(fmt::format("{}: damaged image ({}); copy it again or remove it", name,
                                reports.first.data()));
  }
}

}  // namespace tetrec
