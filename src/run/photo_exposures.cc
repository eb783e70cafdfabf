// Writes and reads exposure.json (schema 1).
#include "run/photo_exposures.h"

#include "core/checked_json.h"
#include "core/file.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

namespace tetrec {
namespace {

using nlohmann::json;

constexpr int kSchema = 1;
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
  const json value = {{"schema", kSchema}, {"views", std::move(views)}};
  ParsePhotoExposures(value, path.string());
  WriteJson(path, value);
}

std::vector<PhotoExposure> ParsePhotoExposures(const json& value, const std::string& name) {
  const CheckedJson file(value, name);
  file.Field("schema").IntegerIn(kSchema, kSchema);
  const CheckedJson views = file.Field("views");
  std::vector<PhotoExposure> exposures;
  std::set<std::string> names;
  for (size_t i = 0; i < views.Size(); ++i) {
    const CheckedJson view = views.Item(i);
    exposures.push_back({view.Field("name").Text(),
                         ReadChannels(view.Field("gain"), kLeastGain, kLargestGain),
                         ReadChannels(view.Field("offset"), -kLargestOffset, kLargestOffset)});
    if (!names.insert(exposures.back().name).second) {
      view.Field("name").Fail(fmt::format("is \"{}\" for the second time", exposures.back().name));
    }
  }
  return exposures;
}

std::vector<PhotoExposure> ReadPhotoExposures(const std::filesystem::path& path) {
  return ParsePhotoExposures(ReadJson(path), path.string());
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
      "{} of {} photos differ in exposure or white balance from the mean of all by more than "
      "{:.0f} % in brightness or {:.2f} in offset; the field is fitted with this undone, but fixed "
      "exposure and white balance give better photos",
      uneven, photos, 100 * kUnevenGain, kUnevenOffset);
}

}  // namespace tetrec
