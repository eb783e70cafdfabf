// What an image file may claim about its size, checked before memory is allocated.
#include "image/size_limits.h"

#include "core/error.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

constexpr uint64_t kMaxSide = uint64_t{1} << 16;
constexpr uint64_t kMaxPixels = uint64_t{1} << 28;

// Pixel bytes that one byte of a file can produce (deflate's limit is 1,032; JPEG has at least one
// bit per 64 pixels).
constexpr uint64_t kMaxPixelBytesPerByte = 1032;

}  // namespace

void CheckSize(uint64_t width, uint64_t height, const std::string& name) {
  if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide ||
      width * height > kMaxPixels) {
    throw DataError(fmt::format(
        "{}: image of {} x {} pixels; expected 1 to {} per side and at most {} in total", name,
        width, height, kMaxSide, kMaxPixels));
  }
}

void CheckAgainstFile(uint64_t pixel_bytes, uint64_t file_bytes, const std::string& name) {
  if (pixel_bytes / kMaxPixelBytesPerByte > file_bytes) {
    throw DataError(
        fmt::format("{}: a file of {} bytes cannot contain the {} bytes of pixels that it claims; "
                    "copy it again or remove it",
                    name, file_bytes, pixel_bytes));
  }
}

}  // namespace tetrec
