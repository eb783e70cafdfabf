// world.json: where a fitted field lies in the input's coordinates. Written beside the field, read
// by what is made from it.
#pragma once

#include "geometry/bounds3.h"
#include "geometry/rigid3.h"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

inline constexpr const char* kFieldWorldFile = "world.json";

// {"schema": 1,
//  "input_from_world": {"scale": s, "rotation": [9 numbers, row by row], "translation": [3]},
//  "subject_bounds": {"min": [3], "max": [3]}, "cameras_in_world": [[3], ...], "scene": "..."}
// `cameras_in_world` and `scene` may be missing; the rotation may also be three rows of three.
struct FieldWorld {
  Similarity3 input_from_world;
  Bounds3 subject_bounds;                    // [world units]
  std::vector<glm::dvec3> cameras_in_world;  // camera centres
  std::string scene;  // the scene folder, relative to the field's; for people only
};

// Throw DataError naming file and field; writing refuses what reading would refuse.
void WriteFieldWorld(const std::filesystem::path& path, const FieldWorld& world);
FieldWorld ReadFieldWorld(const std::filesystem::path& path);
FieldWorld ParseFieldWorld(const nlohmann::json& value, const std::string& name);

}  // namespace tetrec
