// 8-bit pictures in display sRGB and their files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace tetrec {

struct Image {
  int width = 0, height = 0, channels = 3;  // channels: 3 RGB or 4 RGBA with straight alpha
  std::vector<uint8_t> pixels;              // height x width x channels, row by row

  uint8_t* At(int x, int y) { return &pixels[(size_t(y) * width + x) * channels]; }
  const uint8_t* At(int x, int y) const { return &pixels[(size_t(y) * width + x) * channels]; }
};

// .jpg, .jpeg or .png in any case.
bool HasPhotoExtension(const std::filesystem::path& path);

// Black; transparent where there is alpha.
Image MakeImage(int width, int height, int channels);

enum class ExifRotation { kIgnore, kApply };

// Reads PNG, JPEG and EXR, told by their first bytes, as 8-bit RGB or RGBA: 16 bits rounded;
// EXR from linear light with premultiplied alpha to display sRGB, what is not in 0 to 1 clipped and
// counted in `clipped_pixels`. As stored by default, since poses refer to the stored pixels. Throws
// DataError (missing, truncated, no picture, more than 65,536 pixels a side or 2^28 in all, an EXR
// that is no plain picture) and EnvironmentError (no memory, no room for temporary files).
Image ReadImage(const std::filesystem::path& path, ExifRotation rotation = ExifRotation::kIgnore,
                uint64_t* clipped_pixels = nullptr);
// The same from memory, at most INT_MAX bytes; `name` is for messages.
Image DecodeImage(std::span<const uint8_t> bytes, const std::string& name,
                  ExifRotation rotation = ExifRotation::kIgnore,
                  uint64_t* clipped_pixels = nullptr);
// Format by extension (png, jpg). Written by rename.
void WriteImage(const std::filesystem::path& path, const Image& image);

// Area mean: each target pixel is the mean over the part of the source it covers, borders weighted
// by the fraction covered. Alpha is premultiplied while filtering; where it is 0 all channels
// become 0.
Image ResizeByArea(const Image& image, int width, int height);
// Composites straight alpha over a constant: returns RGB.
Image CompositeOver(const Image& rgba, uint8_t r, uint8_t g, uint8_t b);
// The picture with its alpha times the mask's brightness (its largest channel times its alpha). A
// mask of 0 and 1 alone counts as one of 0 and 255; one of another size is resampled by area.
Image MaskedBy(const Image& image, const Image& mask);
// The alpha channel alone, height x width.
std::vector<uint8_t> AlphaOf(const Image& rgba);

}  // namespace tetrec
