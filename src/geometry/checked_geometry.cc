// Geometry in JSON from outside, checked field by field.
#include "geometry/checked_geometry.h"

#include "geometry/rotation.h"

#include <fmt/format.h>

namespace tetrec {

glm::dmat3 CheckedRotation(const glm::dmat3& matrix, double tolerance, const CheckedJson& json) {
  const double distance = DistanceFromRotation(matrix);
  if (!(distance <= tolerance)) {
    json.Fail(fmt::format("is not a rotation: R^T R is off by {:.2g}", distance));
  }
  return matrix;
}

Similarity3 ReadSimilarity(const CheckedJson& json, double rotation_tolerance) {
  const CheckedJson rotation = json.Field("rotation");
  return {json.Field("scale").NumberIn(1e-12, 1e12),
          CheckedRotation(rotation.Matrix3(), rotation_tolerance, rotation),
          json.Field("translation").Vector3()};
}

nlohmann::json ToJson(const Similarity3& similarity) {
  return {{"scale", similarity.scale},
          {"rotation", ToJson(similarity.rotation)},
          {"translation", ToJson(similarity.translation)}};
}

Bounds3 ReadBounds(const CheckedJson& json) {
  const Bounds3 bounds{json.Field("min").Vector3(), json.Field("max").Vector3()};
  if (!glm::all(glm::lessThan(bounds.min, bounds.max))) json.Fail("is an empty box");
  return bounds;
}

nlohmann::json ToJson(const Bounds3& bounds) {
  return {{"min", ToJson(bounds.min)}, {"max", ToJson(bounds.max)}};
}

}  // namespace tetrec
