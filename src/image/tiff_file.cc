// TIFF files by libtiff.
#include "image/tiff_file.h"

#include "core/error.h"
#include "core/log.h"
#include "image/size_limits.h"
#include "image/starts_with.h"

#include <fmt/format.h>
#include <tiffio.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>

namespace tetrec {
namespace {

// Limits on libtiff's buffers. A strip or tile of a plausible file is not larger than its image.
constexpr tmsize_t kMostAtOnce_bytes = tmsize_t{1} << 32;
constexpr uint64_t kSmallPart_bytes = uint64_t{1} << 24, kMostBytesPerPixel = 16;

// A file in memory, as libtiff reads it, and its first complaint.
struct TiffSource {
  std::span<const uint8_t> bytes;
  uint64_t position = 0;
  std::string complaint;
};

tmsize_t Read(thandle_t handle, void* to, tmsize_t size) {
  auto& source = *static_cast<TiffSource*>(handle);
  if (size <= 0 || source.position >= source.bytes.size()) return 0;
  const size_t count = std::min(size_t(size), source.bytes.size() - size_t(source.position));
  std::memcpy(to, source.bytes.data() + source.position, count);
  source.position += count;
  return tmsize_t(count);
}

tmsize_t RefuseToWrite(thandle_t, void*, tmsize_t) { return 0; }

toff_t Seek(thandle_t handle, toff_t offset, int from) {
  auto& source = *static_cast<TiffSource*>(handle);
  const uint64_t start = from == SEEK_CUR   ? source.position
                         : from == SEEK_END ? source.bytes.size()
                                            : 0;
  source.position = start + offset;
  return source.position;
}

int Close(thandle_t) { return 0; }

toff_t Size(thandle_t handle) { return static_cast<TiffSource*>(handle)->bytes.size(); }

int NoteComplaint(TIFF*, void* source, const char*, const char* format, va_list values) {
  std::string& complaint = static_cast<TiffSource*>(source)->complaint;
  char text[300];
  if (complaint.empty() && std::vsnprintf(text, sizeof(text), format, values) > 0) complaint = text;
  return 1;  // handled: nothing is printed
}

int IgnoreWarning(TIFF*, void*, const char*, const char*, va_list) { return 1; }

[[noreturn]] void FailDamaged(const std::string& name, const std::string& reason) {
  throw DataError(fmt::format("{}: damaged image, cannot be decoded{}; copy it again or remove it",
                              name, reason.empty() ? "" : " (" + reason + ")"));
}

using TiffFile = std::unique_ptr<TIFF, void (*)(TIFF*)>;

TiffFile Open(TiffSource& source, const std::string& name) {
  const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(TIFFOpenOptionsAlloc(),
                                                                             TIFFOpenOptionsFree);
  TIFFOpenOptionsSetErrorHandlerExtR(options.get(), NoteComplaint, &source);
  TIFFOpenOptionsSetWarningHandlerExtR(options.get(), IgnoreWarning, nullptr);
  TIFFOpenOptionsSetMaxSingleMemAlloc(options.get(), kMostAtOnce_bytes);
  // "m": not mapped into memory, where it is already.
  TiffFile file(TIFFClientOpenExt("image", "rm", &source, Read, RefuseToWrite, Seek, Close, Size,
                                  nullptr, nullptr, options.get()),
                TIFFClose);
  if (!file) FailDamaged(name, source.complaint);
  return file;
}

void CheckParts(TIFF* file, uint64_t pixels, const std::string& name) {
  const uint64_t part = TIFFIsTiled(file) != 0 ? TIFFTileSize64(file) : TIFFStripSize64(file);
  if (part > std::max(kSmallPart_bytes, pixels * kMostBytesPerPixel)) {
    throw DataError(
        fmt::format("{}: TIFF with a strip or tile of {} bytes for {} pixels; save it again", name,
                    part, pixels));
  }
}

// Throws for what TIFFRGBAImage cannot read, or reads as something else.
void CheckKind(TIFF* file, const std::string& name) {
  uint16_t bits = 0, format = 0;
  TIFFGetFieldDefaulted(file, TIFFTAG_BITSPERSAMPLE, &bits);
  TIFFGetFieldDefaulted(file, TIFFTAG_SAMPLEFORMAT, &format);
  if (bits > 16 || (format != SAMPLEFORMAT_UINT && format != SAMPLEFORMAT_VOID)) {
    throw DataError(fmt::format(
        "{}: TIFF whose samples are not unsigned integers of at most 16 bits; save it again with 8 "
        "or 16 bits per sample",
        name));
  }
  char reason[1024] = "";
  if (TIFFRGBAImageOK(file, reason) == 0) {
    throw DataError(
        fmt::format("{}: TIFF of a kind that is not read ({}); save it again as RGB with 8 or 16 "
                    "bits",
                    name, reason));
  }
}

// Straight colours of premultiplied ones.
uint8_t Straight(uint32_t premultiplied, uint32_t alpha) {
  return alpha == 0 ? uint8_t(0)
                    : uint8_t(std::min(255u, (255 * premultiplied + alpha / 2) / alpha));
}

Image FromRaster(const std::vector<uint32_t>& raster, int width, int height, bool has_alpha) {
  Image image = MakeImage(width, height, has_alpha ? 4 : 3);
  uint8_t* to = image.pixels.data();
  for (const uint32_t pixel : raster) {
    const uint32_t alpha = has_alpha ? TIFFGetA(pixel) : 255;
    for (const uint32_t level : {TIFFGetR(pixel), TIFFGetG(pixel), TIFFGetB(pixel)}) {
      *to++ = Straight(level, alpha);
    }
    if (has_alpha) *to++ = uint8_t(alpha);
  }
  return image;
}

}  // namespace

bool IsTiff(std::span<const uint8_t> bytes) {
  constexpr uint8_t kSignatures[][4] = {{'I', 'I', '*', 0},
                                        {'M', 'M', 0, '*'},  // and large files:
                                        {'I', 'I', '+', 0},
                                        {'M', 'M', 0, '+'}};
  return std::ranges::any_of(
      kSignatures, [&](const uint8_t(&signature)[4]) { return StartsWith(bytes, signature); });
}

Image DecodeTiff(std::span<const uint8_t> bytes, const std::string& name) {
  TiffSource source{bytes, 0, ""};
  const TiffFile file = Open(source, name);
  uint32_t width = 0, height = 0;
  TIFFGetField(file.get(), TIFFTAG_IMAGEWIDTH, &width);
  TIFFGetField(file.get(), TIFFTAG_IMAGELENGTH, &height);
  CheckSize(width, height, name);
  CheckAgainstFile(uint64_t{width} * height, bytes.size(), name);
  CheckKind(file.get(), name);
  CheckParts(file.get(), uint64_t{width} * height, name);
  TIFFRGBAImage reader = {};
  char reason[1024] = "";
  if (TIFFRGBAImageBegin(&reader, file.get(), 1, reason) == 0) FailDamaged(name, reason);
  const std::unique_ptr<TIFFRGBAImage, void (*)(TIFFRGBAImage*)> end(&reader, TIFFRGBAImageEnd);
  reader.req_orientation = reader.orientation;  // as stored
  std::vector<uint32_t> raster(size_t(width) * height);
  if (TIFFRGBAImageGet(&reader, raster.data(), width, height) == 0) {
    FailDamaged(name, source.complaint);
  }
  if (TIFFLastDirectory(file.get()) == 0) {
    LogInfo("{}: TIFF of several pages, of which the first is read", name);
  }
  return FromRaster(raster, int(width), int(height), reader.alpha != 0);
}

CameraNotes CameraNotesOfTiff(std::span<const uint8_t> bytes, const std::string& name) {
  TiffSource source{bytes, 0, ""};
  const TiffFile file = Open(source, name);
  CameraNotes notes;
  const char* text = nullptr;
  if (TIFFGetField(file.get(), TIFFTAG_MAKE, &text) == 1) notes.make = text;
  if (TIFFGetField(file.get(), TIFFTAG_MODEL, &text) == 1) notes.model = text;
  toff_t directory = 0;
  if (TIFFGetField(file.get(), TIFFTAG_EXIFIFD, &directory) != 1 ||
      TIFFReadEXIFDirectory(file.get(), directory) != 1) {
    return notes;
  }
  float focal_length_mm = 0, digital_zoom = 1;
  uint16_t focal_length_35mm = 0;
  if (TIFFGetField(file.get(), EXIFTAG_FOCALLENGTH, &focal_length_mm) == 1 && focal_length_mm > 0 &&
      double(focal_length_mm) < kLongestFocalLength_mm) {
    notes.focal_length_mm = double(focal_length_mm);
  }
  if (TIFFGetField(file.get(), EXIFTAG_FOCALLENGTHIN35MMFILM, &focal_length_35mm) == 1) {
    notes.focal_length_35mm = focal_length_35mm;
  }
  if (TIFFGetField(file.get(), EXIFTAG_DIGITALZOOMRATIO, &digital_zoom) == 1 && digital_zoom > 1) {
    notes.digital_zoom = double(digital_zoom);
  }
  return notes;
}

std::optional<std::vector<uint8_t>> ColorProfileOfTiff(std::span<const uint8_t> bytes,
                                                       const std::string& name) {
  TiffSource source{bytes, 0, ""};
  const TiffFile file = Open(source, name);
  uint32_t size = 0;
  const uint8_t* profile = nullptr;
  if (TIFFGetField(file.get(), TIFFTAG_ICCPROFILE, &size, &profile) != 1) return std::nullopt;
  return std::vector<uint8_t>(profile, profile + size);
}

int OrientationOfTiff(std::span<const uint8_t> bytes, const std::string& name) {
  TiffSource source{bytes, 0, ""};
  const TiffFile file = Open(source, name);
  uint16_t orientation = 0;
  if (TIFFGetField(file.get(), TIFFTAG_ORIENTATION, &orientation) != 1) return 1;
  return orientation >= 1 && orientation <= 8 ? int(orientation) : 1;
}

}  // namespace tetrec
