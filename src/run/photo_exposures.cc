// Writes and reads exposure.json (schema 1).
#include "run/photo_exposures.h"

#include "core/error_context.h"
#include "core/file.h"
#include "run/named_views.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec {
namespace {

using nlohmann::json;

constexpr double kLeastGain = 1e-3, kLargestGain = 1e3, kLargestOffset = 10;

glm::dvec3 ReadChannels(const CheckedJson& field, double least, double largest) {
  if (field.Size() != 3) {
    field.Fail(fmt::format("has {} items; expected 3 numbers", field.Size()));
  }
  glm::dvec3 channels;
  for (int c = 0; c < 3; ++c) channels[c] = field.Item(size_t(c)).NumberIn(least, largest);
  return channels;
}

}  // namespace

void WritePhotoExposures(const std::filesystem::path& path,
                         const std::vector<PhotoExposure>& exposures) {
  json views = json::array();
  for (const PhotoExposure& exposure : exposures) {
    views.push_back({{"name", exposure.name},
                     {"gain", ToJson(exposure.gain)},
                     {"offset", ToJson(exposure.offset)}});
  }
  const json value = NamedViewsFile(std::move(views));
  ParsePhotoExposures(value, path.string());
  WriteJson(path, value);
}

std::vector<PhotoExposure> ParsePhotoExposures(const json& value, const std::string& name) {
  std::vector<PhotoExposure> exposures;
  for (const CheckedJson& view : NamedViews(CheckedJson(value, name))) {
    exposures.push_back({view.Field("name").Text(),
                         ReadChannels(view.Field("gain"), kLeastGain, kLargestGain),
                         ReadChannels(view.Field("offset"), -kLargestOffset, kLargestOffset)});
  }
  return exposures;
}

std::vector<PhotoExposure> ReadPhotoExposures(const std::filesystem::path& path) {
  return Advising("run tetrec-optimize again",
                  [&] { return ParsePhotoExposures(ReadJson(path), path.string()); });
}

bool IsUneven(const PhotoExposure& exposure) {
  for (int c = 0; c < 3; ++c) {
    if (std::abs(exposure.gain[c] - 1) > kUnevenGain) return true;
    if (std::abs(exposure.offset[c]) > kUnevenOffset) return true;
  }
  return false;
}

std::string UnevenWarning(size_t uneven, size_t photos) {
  return fmt::format(
      "{} of {} photos differ in exposure or white balance from the median of all by more than "
      "{:.0f} % in brightness or {:.2f} in offset; the field is fitted with this undone, but fixed "
      "exposure and white balance give better photos",
      uneven, photos, 100 * kUnevenGain, kUnevenOffset);
}

}  // namespace tetrec
