// exposure.json: how each training photo shows the fitted field. Written beside the field, read by
// the report and by whoever wants to match the photos.
#pragma once

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

inline constexpr const char* kPhotoExposuresFile = "exposure.json";

// By channel, in display sRGB: photo = gain field + offset opacity.
struct PhotoExposure {
  std::string name;  // of the scene's view
  glm::dvec3 gain{1.0}, offset{0.0};
};

// {"schema": 1, "views": [{"name", "gain": [3], "offset": [3]}]}
// Throw DataError naming file and field: another schema, a view named twice, a gain that is not
// between 1e-3 and 1e3, an offset beyond +-10. Writing refuses what reading would refuse.
void WritePhotoExposures(const std::filesystem::path& path,
                         const std::vector<PhotoExposure>& exposures);
std::vector<PhotoExposure> ReadPhotoExposures(const std::filesystem::path& path);
std::vector<PhotoExposure> ParsePhotoExposures(const nlohmann::json& value,
                                               const std::string& name);

// True if the photo differs so much from the mean of the photos that people see it beside them: by
// more than a tenth in the gain of a channel, or by more than 0.05 in its offset.
bool IsUneven(const PhotoExposure& exposure);
// "5 of 44 photos differ in exposure ...": for people, with the thresholds of IsUneven.
std::string UnevenWarning(size_t uneven, size_t photos);
inline constexpr double kUnevenGain = 0.1, kUnevenOffset = 0.05;

}  // namespace tetrec
