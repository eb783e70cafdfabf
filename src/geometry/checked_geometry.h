// Geometry in JSON from outside, checked field by field: failures name the file and the field.
#pragma once

#include "core/checked_json.h"
#include "geometry/bounds3.h"
#include "geometry/rigid3.h"

#include <glm/glm.hpp>
#include <nlohmann/json.hpp>

namespace tetrec {

// Returns `matrix`, which was read from `json`. Throws DataError unless it is a rotation: no entry
// of R^T R - I is larger than `tolerance`, and it does not mirror.
glm::dmat3 CheckedRotation(const glm::dmat3& matrix, double tolerance, const CheckedJson& json);

// {"scale", "rotation": 3 rows, "translation": [x, y, z]}; the rotation as in CheckedRotation.
Similarity3 ReadSimilarity(const CheckedJson& json, double rotation_tolerance);
nlohmann::json ToJson(const Similarity3& similarity);

// {"min": [x, y, z], "max": [x, y, z]}. Throws DataError for an empty box.
Bounds3 ReadBounds(const CheckedJson& json);
nlohmann::json ToJson(const Bounds3& bounds);

}  // namespace tetrec
