// What a field's folder says about the world that the field stands in (world.json).
#include "surface/field_world.h"

#include "core/error.h"
#include "core/file.h"

#include <fmt/format.h>

#include <cmath>

namespace tetrec {
namespace {

using nlohmann::json;

const json& Member(const json& object, const char* key, const std::string& name) {
  if (!object.is_object() || !object.contains(key)) {
    throw DataError(fmt::format("{}: '{}' is missing", name, key));
  }
  return object[key];
}

// Numbers of an array, nested ones row by row.
void Append(const json& value, const std::string& name, std::vector<double>& numbers) {
  if (value.is_array()) {
    for (const json& item : value) Append(item, name, numbers);
    return;
  }
  if (!value.is_number() || !std::isfinite(value.get<double>())) {
    throw DataError(fmt::format("{}: a finite number expected, not {}", name, value.dump()));
  }
  numbers.push_back(value.get<double>());
}

std::vector<double> Numbers(const json& value, size_t count, const std::string& name) {
  std::vector<double> numbers;
  Append(value, name, numbers);
  if (numbers.size() != count) {
    throw DataError(fmt::format("{}: {} numbers expected, not {}", name, count, numbers.size()));
  }
  return numbers;
}

glm::dvec3 Vector(const json& value, const std::string& name) {
  const std::vector<double> n = Numbers(value, 3, name);
  return {n[0], n[1], n[2]};
}

Similarity3 ParseSimilarity(const json& value, const std::string& name) {
  Similarity3 result;
  result.scale = Numbers(Member(value, "scale", name), 1, name + ".scale")[0];
  if (!(result.scale > 0)) {
    throw DataError(fmt::format("{}.scale: {} is not positive", name, result.scale));
  }
  const std::vector<double> rows = Numbers(Member(value, "rotation", name), 9, name + ".rotation");
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      result.rotation[column][row] = rows[size_t(3 * row + column)];
    }
  }
  const glm::dmat3 product = glm::transpose(result.rotation) * result.rotation;
  for (int column = 0; column < 3; ++column) {
    // A rotation written with six digits still passes.
    if (glm::distance(product[column], glm::dmat3(1.0)[column]) > 1e-5 ||
        glm::determinant(result.rotation) < 0) {
      throw DataError(fmt::format("{}.rotation: is not a rotation", name));
    }
  }
  result.translation = Vector(Member(value, "translation", name), name + ".translation");
  return result;
}

}  // namespace

FieldWorld ParseFieldWorld(const json& value, const std::string& name) {
  FieldWorld world;
  world.input_from_world =
      ParseSimilarity(Member(value, "input_from_world", name), name + ": input_from_world");
  const json& bounds = Member(value, "subject_bounds", name);
  const std::string bounds_name = name + ": subject_bounds";
  world.subject_bounds = {Vector(Member(bounds, "min", bounds_name), bounds_name + ".min"),
                          Vector(Member(bounds, "max", bounds_name), bounds_name + ".max")};
  if (!glm::all(glm::lessThan(world.subject_bounds.min, world.subject_bounds.max))) {
    throw DataError(fmt::format("{}: min must be below max", bounds_name));
  }
  if (value.contains("cameras_in_world")) {
    const json& cameras = value["cameras_in_world"];
    if (!cameras.is_array()) {
      throw DataError(fmt::format("{}: 'cameras_in_world' must be an array", name));
    }
    for (const json& camera : cameras) {
      world.cameras_in_world.push_back(Vector(camera, name + ": cameras_in_world"));
    }
  }
  return world;
}

FieldWorld ReadFieldWorld(const std::filesystem::path& path) {
  return ParseFieldWorld(ReadJson(path), path.string());
}

}  // namespace tetrec
