// What a field's folder says about the world that the field stands in (world.json).
#pragma once

#include "geometry/bounds3.h"
#include "geometry/rigid3.h"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace tetrec {

// {"input_from_world": {"scale": s, "rotation": [9 numbers, row by row], "translation": [3]},
//  "subject_bounds": {"min": [3], "max": [3]}, "cameras_in_world": [[3], ...]}
// `cameras_in_world` may be missing; rotations may be written as three rows of three.
struct FieldWorld {
  Similarity3 input_from_world;
  Bounds3 subject_bounds;                    // [world units]
  std::vector<glm::dvec3> cameras_in_world;  // camera centres
};

// Throw DataError naming file and field.
FieldWorld ReadFieldWorld(const std::filesystem::path& path);
FieldWorld ParseFieldWorld(const nlohmann::json& value, const std::string& name);

}  // namespace tetrec
