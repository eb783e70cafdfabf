// left_out.json: the training photos that a fit left out, because they do not fit the others.
// Written beside the field, only if there are any; read by whatever else takes these photos.
#pragma once

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

inline constexpr const char* kLeftOutPhotosFile = "left_out.json";

// {"schema": 1, "views": [{"name"}]}, with the names of the scene's views.
// Throw DataError naming file and field: another schema, a view named twice. Writing refuses what
// reading would refuse.
void WriteLeftOutPhotos(const std::filesystem::path& path, const std::vector<std::string>& names);
std::vector<std::string> ReadLeftOutPhotos(const std::filesystem::path& path);

}  // namespace tetrec
