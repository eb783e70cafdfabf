// Writes and reads world.json (schema 1).
#include "run/field_world.h"

#include "core/error_context.h"
#include "core/file.h"
#include "geometry/checked_geometry.h"

#include <fmt/format.h>

namespace tetrec {
namespace {

using nlohmann::json;

constexpr int kWorldSchema = 1;
// A rotation written with six digits still passes.
constexpr double kAxesTolerance = 1e-5;

json FlatRows(const glm::dmat3& matrix) {
  json numbers = json::array();
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) numbers.push_back(matrix[column][row]);
  }
  return numbers;
}

glm::dmat3 ReadRotation(const CheckedJson& field) {
  glm::dmat3 rotation;
  if (field.Size() == 9) {
    for (int i = 0; i < 9; ++i) rotation[i % 3][i / 3] = field.Item(size_t(i)).Number();
  } else if (field.Size() == 3) {
    rotation = field.Matrix3();
  } else {
    field.Fail(fmt::format("has {} items; expected 9 numbers or 3 rows", field.Size()));
  }
  return CheckedRotation(rotation, kAxesTolerance, field);
}

}  // namespace

void WriteFieldWorld(const std::filesystem::path& path, const FieldWorld& world) {
  json cameras = json::array();
  for (const glm::dvec3& center : world.cameras_in_world) cameras.push_back(ToJson(center));
  const json value = {{"schema", kWorldSchema},
                      {"input_from_world",
                       {{"scale", world.input_from_world.scale},
                        {"rotation", FlatRows(world.input_from_world.rotation)},
                        {"translation", ToJson(world.input_from_world.translation)}}},
                      {"subject_bounds", ToJson(world.subject_bounds)},
                      {"cameras_in_world", cameras},
                      {"scene", world.scene}};
  ParseFieldWorld(value, path.string());
  WriteJson(path, value);
}

FieldWorld ParseFieldWorld(const json& value, const std::string& name) {
  const CheckedJson file(value, name);
  file.Field("schema").IntegerIn(kWorldSchema, kWorldSchema);
  FieldWorld world;
  const CheckedJson similarity = file.Field("input_from_world");
  world.input_from_world = {similarity.Field("scale").NumberIn(1e-12, 1e12),
                            ReadRotation(similarity.Field("rotation")),
                            similarity.Field("translation").Vector3()};
  world.subject_bounds = ReadBounds(file.Field("subject_bounds"));
  if (file.Has("cameras_in_world")) {
    const CheckedJson cameras = file.Field("cameras_in_world");
    for (size_t i = 0; i < cameras.Size(); ++i) {
      world.cameras_in_world.push_back(cameras.Item(i).Vector3());
    }
  }
  if (file.Has("scene")) world.scene = file.Field("scene").Text();
  return world;
}

FieldWorld ReadFieldWorld(const std::filesystem::path& path) {
  return Advising("run tetrec-optimize again",
                  [&] { return ParseFieldWorld(ReadJson(path), path.string()); });
}

}  // namespace tetrec
