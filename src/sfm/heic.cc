// HEIC photos by heif-convert as a child process.
#include "sfm/heic.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "core/printable.h"
#include "image/jpeg_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <string_view>

namespace tetrec {
namespace fs = std::filesystem;
namespace {

// Several times what a photo of 200 megapixels needs.
constexpr uint64_t kMostMemory_bytes = uint64_t{6} << 30;
constexpr double kTimeLimit_s = 600;

std::string ReasonOf(const ChildResult& result) {
  if (result.exit_code > 128) {
    return fmt::format("heif-convert was ended by signal {}", result.exit_code - 128);
  }
  return result.last_lines.empty() ? "no reason given" : Printable(result.last_lines.back());
}

// heif-convert does not notice that a disk is full, and a file that was cut off must not be taken
// for the photo by later runs.
bool IsComplete(const fs::path& jpeg) {
  try {
    ReadJpegMarkers(ReadBytes(jpeg), jpeg.string());
    return true;
  } catch (const DataError&) {
    return false;
  }
}

[[noreturn]] void Refuse(const fs::path& photo, const std::string& reason,
                         const fs::path& scratch) {
  fs::remove_all(scratch);
  throw DataError(
      fmt::format("{}: cannot be read as HEIC ({}); copy it again, or convert it to JPEG",
                  photo.string(), reason));
}

// Writes photo.jpg into the working folder.
ChildResult Convert(const fs::path& program, const fs::path& photo, const ChildOptions& options,
                    const fs::path& scratch) {
  try {
    return RunChild(program, {"--quiet", "-q", "100", fs::absolute(photo).string(), "photo.jpg"},
                    options);
  } catch (const ChildTimedOut& error) {
    Refuse(photo, error.what(), scratch);
  }
}

}  // namespace

bool IsHeic(std::span<const uint8_t> front) {
  // A file type box, whose first brand is one of images. (ISO 14496-12 and 23008-12)
  constexpr std::string_view kBrands[] = {"heic", "heix", "heim", "heis", "hevc",
                                          "hevx", "mif1", "mif2", "msf1"};
  if (front.size() < 12 || std::memcmp(&front[4], "ftyp", 4) != 0) return false;
  const std::string_view brand(reinterpret_cast<const char*>(&front[8]), 4);
  return std::find(std::begin(kBrands), std::end(kBrands), brand) != std::end(kBrands);
}

void ConvertHeic(const fs::path& photo, const fs::path& jpeg, const fs::path& scratch) {
  const fs::path program = FindProgram("heif-convert");
  if (program.empty()) {
    throw EnvironmentError(fmt::format(
        "{}: heif-convert, which reads HEIC photos, is not in PATH; install it: apt-get install "
        "--no-install-recommends libheif-examples",
        photo.string()));
  }
  fs::remove_all(scratch);
  fs::create_directories(scratch);
  ChildOptions options;
  options.working_folder = scratch;
  options.max_memory_bytes = kMostMemory_bytes;
  options.time_limit_s = kTimeLimit_s;
  const ChildResult result = Convert(program, photo, options, scratch);
  // A file of several images becomes several files.
  const bool has_several = fs::exists(scratch / "photo-1.jpg");
  const fs::path written = scratch / (has_several ? "photo-1.jpg" : "photo.jpg");
  if (result.exit_code != 0 || !fs::exists(written)) {
    Refuse(photo, ReasonOf(result), scratch);
  }
  if (!IsComplete(written)) {
    fs::remove_all(scratch);
    throw EnvironmentError(
        fmt::format("{}: heif-convert did not write all of {}; free some space and run it again, "
                    "or convert the photo to JPEG",
                    photo.string(), jpeg.string()));
  }
  if (has_several) {
    LogInfo("{}: HEIC file of several images, of which the first is used", photo.string());
  }
  fs::rename(written, jpeg);
  fs::remove_all(scratch);
}

}  // namespace tetrec
