// Image files by OpenCV, with the checks that OpenCV leaves out.
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/lower_case.h"
#include "image/codecs.h"
#include "image/depth_map.h"
#include "image/exr_header.h"
#include "image/image.h"
#include "image/jpeg_data.h"
#include "image/normal_map.h"
#include "image/photo.h"
#include "image/png_data.h"
#include "image/size_limits.h"
#include "image/srgb.h"
#include "image/starts_with.h"
#include "image/tiff_file.h"

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <string_view>

namespace tetrec {
namespace {

constexpr uint64_t kMaxFileBytes = std::numeric_limits<int>::max();  // OpenCV's limit

// More than any program writes; each scan of a short file may cost as much as the whole image.
constexpr int kMostJpegScans = 500;

void CheckJpeg(std::span<const uint8_t> bytes, const std::string& name) {
  const JpegFacts facts = ReadJpegMarkers(bytes, name);
  CheckSize(facts.size.x, facts.size.y, name);
  CheckAgainstFile(facts.size.x * facts.size.y, bytes.size(), name);
  if (facts.scans > kMostJpegScans) {
    throw DataError(fmt::format("{}: JPEG of {} scans, of which at most {} are read; save it again",
                                name, facts.scans, kMostJpegScans));
  }
  CheckJpegScans(bytes, name);
}

PhotoNotes NotesOf(std::span<const uint8_t> bytes, const std::string& name) {
  if (IsTiff(bytes)) return {OrientationOfTiff(bytes, name), CameraNotesOfTiff(bytes, name)};
  if (!IsJpeg(bytes)) return {};
  const JpegFacts facts = ReadJpegMarkers(bytes, name);
  return {facts.notes.orientation, facts.camera};
}

// OpenCV reads EXR only if this environment variable is set when it first looks. It is set before
// any thread starts, since the environment is not thread-safe.
const bool kExrEnabled = setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 1) == 0;

cv::Mat Decode(std::span<const uint8_t> bytes, const std::string& name, ExifRotation rotation) {
  // IMREAD_UNCHANGED alone ignores the rotation too.
  const int flags = rotation == ExifRotation::kApply
                        ? int(cv::IMREAD_ANYCOLOR) | int(cv::IMREAD_ANYDEPTH)
                        : int(cv::IMREAD_UNCHANGED) | int(cv::IMREAD_IGNORE_ORIENTATION);
  try {
    const cv::Mat encoded(1, int(bytes.size()), CV_8U, const_cast<uint8_t*>(bytes.data()));
    return OpenCvCodecs().decode(encoded, flags);
  } catch (const cv::Exception& error) {
    // Not the image's fault, for which OpenCV does not throw: there is no memory, or no space for
    // the temporary file that OpenCV uses to read EXR.
    std::string reason = error.err;
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw EnvironmentError(fmt::format("{}: cannot be decoded: {}", name, reason));
  }
}

// The channels in the order RGB or RGBA, 8 bits each.
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
      throw DataError(
          fmt::format("{}: samples are integers of more than 16 bits; convert it to PNG", name));
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
          fmt::format("{}: image with {} channels; expected 1, 3 or 4", name, eight.channels()));
  }
  return rgb;
}

// A level from 0 to 255. Sets `is_clipped` for values outside, including infinities and NaN (which
// becomes black).
uint8_t ToByteOrClip(double value, bool& is_clipped) {
  constexpr double kHalfLevel = 0.5 / 255;
  if (!(value >= -kHalfLevel && value <= 1 + kHalfLevel)) is_clipped = true;
  return std::isnan(value) ? 0 : uint8_t(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

// Converts 1 to 4 floats per pixel: grey, or blue, green and red; then alpha, if any. The source is
// in linear light and premultiplied.
Image DisplayFromExr(const cv::Mat& linear, uint64_t& clipped_pixels) {
  const int channels = linear.channels();
  const bool is_grey = channels < 3, has_alpha = channels % 2 == 0;
  Image image = MakeImage(linear.cols, linear.rows, has_alpha ? 4 : 3);
  for (int y = 0; y < image.height; ++y) {
    const float* source = linear.ptr<float>(y);
    for (int x = 0; x < image.width; ++x, source += channels) {
      bool is_clipped = false;
      uint8_t* pixel = image.At(x, y);
      const double alpha = has_alpha ? double(source[channels - 1]) : 1.0;
      if (has_alpha) pixel[3] = ToByteOrClip(alpha, is_clipped);
      if (!has_alpha || pixel[3] > 0) {
        const double divisor = std::clamp(alpha, 0.0, 1.0);
        for (int c = 0; c < 3; ++c) {
          const double value = source[is_grey ? 0 : 2 - c] / divisor;
          pixel[c] = ToByteOrClip(SrgbFromLinear(value), is_clipped);
        }
      }
      clipped_pixels += is_clipped;
    }
  }
  return image;
}

// OpenCV would pass a file with this word at this place, whatever it starts with, to its reader of
// medical images, which trusts the lengths that it finds.
void RefuseDicom(std::span<const uint8_t> bytes, const std::string& name) {
  constexpr size_t kPlace = 128;
  constexpr std::string_view kWord = "DICM";
  if (bytes.size() < kPlace + kWord.size()) return;
  if (std::memcmp(&bytes[kPlace], kWord.data(), kWord.size()) != 0) return;
  throw DataError(
      fmt::format("{}: EXR with the mark of a DICOM file at byte 128; save it again", name));
}

// Checks everything that OpenEXR does not before it decodes.
void CheckExr(std::span<const uint8_t> bytes, const std::string& name) {
  RefuseDicom(bytes, name);
  const glm::u64vec2 size = CheckExrHeader(bytes, name);
  CheckSize(size.x, size.y, name);
  CheckAgainstFile(size.x * size.y, bytes.size(), name);
}

// The type of values that an EXR file of measurements must have.
struct ExrContent {
  int type;             // of OpenCV
  const char* refusal;  // of a file of another type
};

cv::Mat DecodeFloats(const std::filesystem::path& path, const ExrContent& content) {
  const std::vector<uint8_t> bytes = ReadBytes(path, kMaxFileBytes);
  const std::string name = path.string();
  if (!StartsWith(bytes, kExrSignature)) {
    throw DataError(fmt::format("{}: {}, in OpenEXR", name, content.refusal));
  }
  CheckExr(bytes, name);
  cv::Mat decoded = Decode(bytes, name, ExifRotation::kIgnore);
  if (decoded.empty()) {
    throw DataError(fmt::format("{}: damaged map, cannot be decoded; render it again", name));
  }
  if (decoded.type() != content.type) {
    throw DataError(fmt::format("{}: {}", name, content.refusal));
  }
  return decoded;
}

void WriteEncoded(const std::filesystem::path& path, const std::string& extension,
                  const cv::Mat& pixels) {
  std::vector<uint8_t> bytes;
  TETREC_CHECK(OpenCvCodecs().encode(extension, pixels, bytes, {}), "encoding " + path.string());
  WriteBytes(path, bytes);
}

}  // namespace

bool HasPhotoExtension(const std::filesystem::path& path) {
  const std::string extension = LowerExtension(path);
  return extension == ".jpg" || extension == ".jpeg" || extension == ".jpe" ||
         extension == ".jfif" || extension == ".png" || extension == ".tif" || extension == ".tiff";
}

Image DecodeImage(std::span<const uint8_t> bytes, const std::string& name, ExifRotation rotation,
                  uint64_t* clipped_pixels) {
  TETREC_CHECK(bytes.size() <= kMaxFileBytes, name);
  const bool is_png = IsPng(bytes), is_jpeg = IsJpeg(bytes);
  const bool is_exr = StartsWith(bytes, kExrSignature);
  if (bytes.empty()) throw DataError(fmt::format("{}: empty file, expected an image", name));
  if (IsTiff(bytes)) return DecodeTiff(bytes, name);
  if (!is_png && !is_jpeg && !is_exr) {
    throw DataError(
        fmt::format("{}: not an image that can be read; expected PNG, JPEG, TIFF or EXR", name));
  }
  const PngFacts png = is_png ? ReadPngChunks(bytes, name) : PngFacts{};
  if (is_jpeg) CheckJpeg(bytes, name);

  if (is_exr) CheckExr(bytes, name);

  const cv::Mat decoded = Decode(bytes, name, rotation);
  if (decoded.empty()) {
    throw DataError(
        fmt::format("{}: damaged image, cannot be decoded; copy it again or remove it", name));
  }
  CheckSize(uint64_t(decoded.cols), uint64_t(decoded.rows), name);
  if (png.has_transparency_chunk && decoded.channels() < 4) {
    LogWarning("{}: its transparent colour is treated as opaque; store an alpha channel instead",
               name);
  }
  if (is_exr && decoded.depth() == CV_32F) {
    uint64_t ignored = 0;
    return DisplayFromExr(decoded, clipped_pixels != nullptr ? *clipped_pixels : ignored);
  }
  const cv::Mat rgb = ToEightBitRgb(decoded, name);
  Image image = MakeImage(rgb.cols, rgb.rows, rgb.channels());
  const size_t row_bytes = size_t(rgb.cols) * size_t(rgb.channels());
  for (int y = 0; y < rgb.rows; ++y) std::memcpy(image.At(0, y), rgb.ptr(y), row_bytes);
  return image;
}

Image ReadImage(const std::filesystem::path& path, ExifRotation rotation,
                uint64_t* clipped_pixels) {
  return DecodeImage(ReadBytes(path, kMaxFileBytes), path.string(), rotation, clipped_pixels);
}

Image ReadPicture(const std::filesystem::path& path, ProfileUse& use, ExifRotation rotation,
                  uint64_t* clipped_pixels) {
  const std::vector<uint8_t> bytes = ReadBytes(path, kMaxFileBytes);
  Image image = DecodeImage(bytes, path.string(), rotation, clipped_pixels);
  use = ApplyColorProfile(bytes, path.string(), image);
  return image;
}

bool IsDeepColorPng(std::span<const uint8_t> front) {
  constexpr size_t kDepth = 24, kColorType = 25;  // of the header chunk, which is the first
  return IsPng(front) && front.size() > kColorType && front[kDepth] == 16 && front[kColorType] != 0;
}

Image ReadPhoto(const std::filesystem::path& path, PhotoNotes* notes) {
  const std::vector<uint8_t> bytes = ReadBytes(path, kMaxFileBytes);
  if (!bytes.empty() && !IsPng(bytes) && !IsJpeg(bytes) && !IsTiff(bytes)) {
    throw DataError(fmt::format(
        "{}: not a photo that can be read; expected JPEG, PNG, TIFF or HEIC", path.string()));
  }
  Image image = DecodeImage(bytes, path.string());
  if (notes != nullptr) *notes = NotesOf(bytes, path.string());
  return image;
}

void WriteImage(const std::filesystem::path& path, const Image& image) {
  const std::string extension = LowerExtension(path);
  const bool is_jpeg = extension == ".jpg" || extension == ".jpeg";
  TETREC_CHECK(extension == ".png" || is_jpeg, "image format of " + path.string());
  TETREC_CHECK(!is_jpeg || image.channels == 3, "JPEG has no alpha: " + path.string());
  TETREC_CHECK(
      image.pixels.size() == size_t(image.width) * size_t(image.height) * size_t(image.channels),
      "size of image " + path.string());

  const cv::Mat rgb(image.height, image.width, CV_8UC(image.channels),
                    const_cast<uint8_t*>(image.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(rgb, bgr, image.channels == 4 ? cv::COLOR_RGBA2BGRA : cv::COLOR_RGB2BGR);
  WriteEncoded(path, extension, bgr);
}

std::vector<uint8_t> EncodeJpeg(const Image& rgb, int quality) {
  TETREC_CHECK(rgb.channels == 3 && !rgb.pixels.empty(), "JPEG images are RGB");
  const cv::Mat view(rgb.height, rgb.width, CV_8UC3, const_cast<uint8_t*>(rgb.pixels.data()));
  cv::Mat bgr;
  cv::cvtColor(view, bgr, cv::COLOR_RGB2BGR);
  std::vector<uint8_t> bytes;
  TETREC_CHECK(OpenCvCodecs().encode(".jpg", bgr, bytes, {cv::IMWRITE_JPEG_QUALITY, quality}),
               "JPEG encoder");
  return bytes;
}

void WriteDepthMap(const std::filesystem::path& path, const DepthMap& map) {
  TETREC_CHECK(map.depth.size() == size_t(map.width) * size_t(map.height), path.string());
  WriteEncoded(path, ".exr",
               cv::Mat(map.height, map.width, CV_32FC1, const_cast<float*>(map.depth.data())));
}

DepthMap ReadDepthMap(const std::filesystem::path& path) {
  const std::string name = path.string();
  const cv::Mat decoded =
      DecodeFloats(path, {CV_32FC1, "not a depth map; expected one channel of floats"});
  DepthMap map = MakeDepthMap(decoded.cols, decoded.rows);
  for (int y = 0; y < map.height; ++y) {
    std::copy_n(decoded.ptr<float>(y), map.width, &map.At(0, y));
  }
  for (const float depth : map.depth) {
    if (!(depth >= 0 && std::isfinite(depth))) {
      throw DataError(
          fmt::format("{}: a depth is {}; expected a number of at least 0", name, depth));
    }
  }
  return map;
}

void WriteNormalMap(const std::filesystem::path& path, const NormalMap& map) {
  cv::Mat bgr(map.height, map.width, CV_32FC3);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const glm::vec3& normal = map.At(x, y);
      bgr.at<cv::Vec3f>(y, x) = {normal.z, normal.y, normal.x};
    }
  }
  WriteEncoded(path, ".exr", bgr);
}

NormalMap ReadNormalMap(const std::filesystem::path& path) {
  const cv::Mat bgr =
      DecodeFloats(path, {CV_32FC3, "not a normal map; expected three channels of floats"});
  NormalMap map = MakeNormalMap(bgr.cols, bgr.rows);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const auto& value = bgr.at<cv::Vec3f>(y, x);
      const glm::vec3 normal(value[2], value[1], value[0]);
      const double length = glm::length(glm::dvec3(normal));
      if (normal != glm::vec3(0.0f) && !(std::abs(length - 1) < 1e-3)) {
        throw DataError(
            fmt::format("{}: a normal has length {}; expected 1, or 0 without a surface",
                        path.string(), length));
      }
      map.At(x, y) = normal;
    }
  }
  return map;
}

}  // namespace tetrec
