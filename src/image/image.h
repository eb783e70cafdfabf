// 8-bit images in display sRGB and their files.
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

// True for .jpg, .jpeg, .jpe, .jfif, .png, .tif and .tiff, in upper or lower case.
bool HasPhotoExtension(const std::filesystem::path& path);

// A black image; transparent if it has alpha.
Image MakeImage(int width, int height, int channels);

enum class ExifRotation { kIgnore, kApply };

// Reads PNG, JPEG, TIFF and EXR files, recognised by their first bytes, as 8-bit RGB or RGBA. 16
// bits are rounded. EXR is converted from linear light with premultiplied alpha to display sRGB;
// values outside 0 to 1 are clipped, and their pixels counted in `clipped_pixels`. By default the
// image is as stored, since poses refer to the stored pixels. Colour profiles are left to
// ReadPicture (photo.h), because masks and maps are not colours. Throws DataError (missing,
// truncated, not an image, more than 65,536 pixels per side or 2^28 in total, an EXR that is not
// one plain image) and EnvironmentError (no memory, no space for temporary files).
Image ReadImage(const std::filesystem::path& path, ExifRotation rotation = ExifRotation::kIgnore,
                uint64_t* clipped_pixels = nullptr);
// The same from memory, from at most INT_MAX bytes; `name` is for messages.
Image DecodeImage(std::span<const uint8_t> bytes, const std::string& name,
                  ExifRotation rotation = ExifRotation::kIgnore,
                  uint64_t* clipped_pixels = nullptr);
// The extension (png, jpg) selects the format. The file appears by rename.
void WriteImage(const std::filesystem::path& path, const Image& image);

// An RGB image as the bytes of a JPEG file, with a quality from 0 to 100.
std::vector<uint8_t> EncodeJpeg(const Image& rgb, int quality);

// Area mean: each target pixel is the mean over the part of the source that it covers; pixels at
// the border of that part are weighted by the fraction covered. Alpha is premultiplied while
// filtering; if it is 0, all channels become 0.
Image ResizeByArea(const Image& image, int width, int height);
// Composites straight alpha over a constant colour; returns RGB.
Image CompositeOver(const Image& rgba, uint8_t r, uint8_t g, uint8_t b);
// The image turned clockwise by this number of quarter turns.
Image TurnedClockwise(const Image& image, int quarters);
// The image with its alpha multiplied by the mask's brightness (its largest channel times its
// alpha). A mask that contains only 0 and 1 is treated as one of 0 and 255; a mask of another size
// is resampled by area.
Image MaskedBy(const Image& image, const Image& mask);
// The alpha channel alone, height x width.
std::vector<uint8_t> AlphaOf(const Image& rgba);

}  // namespace tetrec
