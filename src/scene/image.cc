// Picture files by OpenCV, with the checks that OpenCV leaves out; exact area mean and compositing.
#include "scene/image.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstring>

namespace tetrec {
namespace {

constexpr uint64_t kMaxSide = uint64_t{1} << 16;
constexpr uint64_t kMaxPixels = uint64_t{1} << 28;
constexpr uint64_t kMaxFileBytes = uint64_t{1} << 31;

uint32_t BigEndian16(const uint8_t* p) { return uint32_t(p[0]) << 8 | p[1]; }
uint32_t BigEndian32(const uint8_t* p) { return BigEndian16(p) << 16 | BigEndian16(p + 2); }

void CheckSize(uint64_t width, uint64_t height, const std::string& name) {
  if (width == 0 || height == 0 || width > kMaxSide || height > kMaxSide ||
      width * height > kMaxPixels) {
    throw DataError(
        fmt::format("{}: picture of {} x {} pixels; expected 1 to {} a side and at most {} in all",
                    name, width, height, kMaxSide, kMaxPixels));
  }
}

[[noreturn]] void FailTruncated(const std::string& name, size_t bytes) {
  throw DataError(fmt::format(
      "{}: truncated picture, ends after {} bytes; copy it again or remove it", name, bytes));
}

constexpr uint8_t kPngSignature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};

// What a PNG's chunks say before it is decoded.
struct PngFacts {
  bool has_transparency_chunk = false;
};

// Walks the chunks to IEND: the decoder takes a cut file for a whole one. (PNG, ISO 15948, section
// 5)
PngFacts CheckPng(std::span<const uint8_t> bytes, const std::string& name) {
  PngFacts facts;
  size_t position = sizeof(kPngSignature);
  bool header_seen = false;
  while (bytes.size() - position >= 12) {
    const uint64_t length = BigEndian32(&bytes[position]);
    const uint8_t* type = &bytes[position + 4];
    if (length > bytes.size() - position - 12) break;
    if (std::memcmp(type, "IHDR", 4) == 0 && length >= 8) {
      CheckSize(BigEndian32(type + 4), BigEndian32(type + 8), name);
      header_seen = true;
    }
    if (!header_seen) throw DataError(fmt::format("{}: PNG file without a header chunk", name));
    if (std::memcmp(type, "tRNS", 4) == 0) facts.has_transparency_chunk = true;
    if (std::memcmp(type, "IEND", 4) == 0) return facts;
    position += 12 + length;
  }
  FailTruncated(name, bytes.size());
}

// Position behind the next marker's two bytes; byte stuffing, fill bytes and restart markers passed
// over. 0 where there is none.
size_t NextJpegMarker(std::span<const uint8_t> bytes, size_t position) {
  for (; position + 1 < bytes.size(); ++position) {
    const uint8_t code = bytes[position + 1];
    const bool is_marker = code != 0x00 && code != 0xFF && (code < 0xD0 || code > 0xD7);
    if (bytes[position] == 0xFF && is_marker) return position + 2;
  }
  return 0;
}

// Walks the markers to EOI, since the decoder fills what is missing with grey. A search for the
// last EOI would not do: thumbnails have their own. (JPEG, ITU T.81, annex B)
void CheckJpeg(std::span<const uint8_t> bytes, const std::string& name) {
  size_t position = 2;
  while ((position = NextJpegMarker(bytes, position)) != 0) {
    const uint8_t code = bytes[position - 1];
    if (code == 0xD9) return;                    // EOI
    if (code == 0x01 || code == 0xD8) continue;  // markers without a segment
    if (bytes.size() - position < 2) break;
    const size_t length = BigEndian16(&bytes[position]);
    if (length > bytes.size() - position) break;
    const bool is_frame =
        code >= 0xC0 && code <= 0xCF && code != 0xC4 && code != 0xC8 && code != 0xCC;
    if (is_frame && length >= 7) {
      CheckSize(BigEndian16(&bytes[position + 5]), BigEndian16(&bytes[position + 3]), name);
    }
    position += length;
  }
  FailTruncated(name, bytes.size());
}

cv::Mat Decode(std::span<const uint8_t> bytes, const std::string& name) {
  try {
    const cv::Mat encoded(1, int(bytes.size()), CV_8U, const_cast<uint8_t*>(bytes.data()));
    return cv::imdecode(encoded, cv::IMREAD_UNCHANGED | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception& error) {
    std::string reason = error.err;
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw DataError(fmt::format("{}: cannot be decoded: {}", name, reason));
  }
}

// RGB or RGBA order, 8 bits.
cv::Mat ToEightBitRgb(const cv::Mat& decoded, const std::string& name) {
  cv::Mat eight;
  switch (decoded.depth()) {
    case CV_8U:
      eight = decoded;
      break;
    case CV_16U:
      decoded.convertTo(eight, CV_8U, 1.0 / 257.0);
      break;
    default:
      throw DataError(fmt::format(
          "{}: samples are neither 8 nor 16 bit whole numbers; convert it to PNG or JPEG", name));
  }
  cv::Mat rgb;
  switch (eight.channels()) {
    case 1:
      cv::cvtColor(eight, rgb, cv::COLOR_GRAY2RGB);
      break;
    case 3:
      cv::cvtColor(eight, rgb, cv::COLOR_BGR2RGB);
      break;
    case 4:
      cv::cvtColor(eight, rgb, cv::COLOR_BGRA2RGBA);
      break;
    default:
      throw DataError(
          fmt::format("{}: picture of {} channels; expected 1, 3 or 4", name, eight.channels()));
  }
  return rgb;
}

// The source pixels under one target pixel along one axis; weights sum to 1.
struct Coverage {
  int first = 0;
  std::vector<double> weights;
};

std::vector<Coverage> CoverAxis(int source_size, int target_size) {
  std::vector<Coverage> axis(size_t(target_size), Coverage{});
  for (int64_t i = 0; i < target_size; ++i) {
    // In units of 1 / target_size of a source pixel everything is a whole number: no rounding.
    const int64_t begin = i * source_size, end = begin + source_size;
    Coverage& coverage = axis[size_t(i)];
    coverage.first = int(begin / target_size);
    for (int64_t s = coverage.first; s * target_size < end; ++s) {
      const int64_t covered =
          std::min(end, (s + 1) * target_size) - std::max(begin, s * target_size);
      coverage.weights.push_back(double(covered) / source_size);
    }
  }
  return axis;
}

uint8_t ToByte(double value) { return uint8_t(std::clamp(value + 0.5, 0.0, 255.0)); }

}  // namespace

Image MakeImage(int width, int height, int channels) {
  TETREC_CHECK(width > 0 && height > 0 && (channels == 3 || channels == 4),
               fmt::format("{} x {} x {}", width, height, channels));
  Image image{width, height, channels, {}};
  image.pixels.resize(size_t(width) * size_t(height) * size_t(channels));
  return image;
}

Image DecodeImage(std::span<const uint8_t> bytes, const std::string& name) {
  const bool is_png = bytes.size() >= sizeof(kPngSignature) &&
                      std::memcmp(bytes.data(), kPngSignature, sizeof(kPngSignature)) == 0;
  const bool is_jpeg =
      bytes.size() >= 3 && bytes[0] == 0xFF && bytes[1] == 0xD8 && bytes[2] == 0xFF;
  if (bytes.empty()) throw DataError(fmt::format("{}: empty file, expected a picture", name));
  if (bytes.size() > kMaxFileBytes) {
    throw DataError(fmt::format("{}: {} bytes are too many for a picture", name, bytes.size()));
  }
  const PngFacts png = is_png ? CheckPng(bytes, name) : PngFacts{};
  if (is_jpeg) CheckJpeg(bytes, name);

  const cv::Mat decoded = Decode(bytes, name);
  if (decoded.empty()) {
    throw DataError(fmt::format("{}: not a picture that can be read; expected PNG or JPEG", name));
  }
  CheckSize(uint64_t(decoded.cols), uint64_t(decoded.rows), name);
  if (png.has_transparency_chunk && decoded.channels() < 4) {
    LogWarning("{}: its transparent colour is taken as opaque; store an alpha channel instead",
               name);
  }
  const cv::Mat rgb = ToEightBitRgb(decoded, name);
  Image image = MakeImage(rgb.cols, rgb.rows, rgb.channels());
  const size_t row_bytes = size_t(rgb.cols) * size_t(rgb.channels());
  for (int y = 0; y < rgb.rows; ++y) std::memcpy(image.At(0, y), rgb.ptr(y), row_bytes);
  return image;
}

Image ReadImage(const std::filesystem::path& path) {
  return DecodeImage(ReadBytes(path, kMaxFileBytes), path.string());
}

void WriteImage(const std::filesystem::path& path, const Image& image) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](char c) { return char(std::tolower(uint8_t(c))); });
  const bool is_jpeg = extension == ".jpg" || extension == ".jpeg";
  TETREC_CHECK(extension == ".png" || is_jpeg, "picture format of " + path.string());
  TETREC_CHECK(!is_jpeg || image.channels == 3, "JPEG has no alpha: " + path.string());
  TETREC_CHECK(
      image.pixels.size() == size_t(image.width) * size_t(image.height) * size_t(image.channels),
      "size of picture " + path.string());

  const cv::Mat rgb(image.height, image.width, CV_8UC(image.channels),
                    const_cast<uint8_t*>(image.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, image.channels == 4 ? cv::COLOR_RGBA2BGRA : cv::COLOR_RGB2BGR);
  std::vector<uint8_t> bytes;
  TETREC_CHECK(cv::imencode(extension, bgr, bytes), "encoding " + path.string());
  WriteBytes(path, bytes);
}

Image ResizeByArea(const Image& image, int width, int height) {
  Image target = MakeImage(width, height, image.channels);
  const std::vector<Coverage> columns = CoverAxis(image.width, width);
  const std::vector<Coverage> rows = CoverAxis(image.height, height);
  const bool has_alpha = image.channels == 4;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Coverage &column = columns[size_t(x)], &row = rows[size_t(y)];
      double sum[3] = {0, 0, 0}, sum_alpha = 0;
      for (size_t j = 0; j < row.weights.size(); ++j) {
        const uint8_t* source = image.At(column.first, row.first + int(j));
        for (size_t i = 0; i < column.weights.size(); ++i, source += image.channels) {
          const double weight = row.weights[j] * column.weights[i] * (has_alpha ? source[3] : 1.0);
          for (int c = 0; c < 3; ++c) sum[c] += weight * source[c];
          sum_alpha += weight;
        }
      }
      uint8_t* pixel = target.At(x, y);
      if (has_alpha) pixel[3] = ToByte(sum_alpha);
      if (has_alpha && pixel[3] == 0) continue;
      for (int c = 0; c < 3; ++c) pixel[c] = ToByte(sum[c] / sum_alpha);
    }
  }
  return target;
}

Image CompositeOver(const Image& rgba, uint8_t r, uint8_t g, uint8_t b) {
  TETREC_CHECK(rgba.channels == 4, "compositing needs alpha");
  Image rgb = MakeImage(rgba.width, rgba.height, 3);
  const int background[3] = {r, g, b};
  const size_t count = size_t(rgba.width) * size_t(rgba.height);
  for (size_t i = 0; i < count; ++i) {
    const int alpha = rgba.pixels[4 * i + 3];
    for (size_t c = 0; c < 3; ++c) {
      const int mixed = rgba.pixels[4 * i + c] * alpha + background[c] * (255 - alpha);
      rgb.pixels[3 * i + c] = uint8_t((mixed + 127) / 255);
    }
  }
  return rgb;
}

std::vector<uint8_t> AlphaOf(const Image& rgba) {
  TETREC_CHECK(rgba.channels == 4, "a picture without alpha");
  std::vector<uint8_t> alpha(size_t(rgba.width) * size_t(rgba.height));
  for (size_t i = 0; i < alpha.size(); ++i) alpha[i] = rgba.pixels[4 * i + 3];
  return alpha;
}

}  // namespace tetrec
