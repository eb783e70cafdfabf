#include "surface/field_world.h"

#include "core/error.h"
#include "expect_error.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

nlohmann::json Example() {
  return nlohmann::json::parse(R"({
    "input_from_world": {"scale": 2, "rotation": [0, -1, 0, 1, 0, 0, 0, 0, 1], "translation": [1, 2, 3]},
    "subject_bounds": {"min": [-1, -1, -1], "max": [1, 1, 1]},
    "cameras_in_world": [[4, 5, 6]]})");
}

TEST(ParseFieldWorld, ReadsRotationsRowByRow) {
  const FieldWorld world = ParseFieldWorld(Example(), "world.json");
  EXPECT_EQ(world.input_from_world * glm::dvec3(1, 0, 0), glm::dvec3(1, 4, 3));
  EXPECT_EQ(world.cameras_in_world.at(0), glm::dvec3(4, 5, 6));
  nlohmann::json nested = Example();
  nested["input_from_world"]["rotation"] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
  EXPECT_EQ(ParseFieldWorld(nested, "world.json").input_from_world * glm::dvec3(1, 0, 0),
            glm::dvec3(1, 4, 3));
}

TEST(ParseFieldWorld, NamesTheBadField) {
  const auto refused = [](const std::string& path, const nlohmann::json& value,
                          const std::string& reason) {
    nlohmann::json world = Example();
    world[nlohmann::json::json_pointer(path)] = value;
    ExpectError<DataError>([&] { ParseFieldWorld(world, "world.json"); }, {"world.json", reason});
  };
  refused("/input_from_world/scale", 0, "input_from_world.scale: 0 is not positive");
  refused("/input_from_world/scale", "x",
          "input_from_world.scale: a finite number expected, not \"x\"");
  refused("/input_from_world/rotation/0", 0.5, "is not a rotation");
  refused("/input_from_world/rotation/8", -1, "is not a rotation");
  refused("/input_from_world/translation", {1, 2},
          "input_from_world.translation: 3 numbers expected, not 2");
  refused("/subject_bounds/min", {1, 2, 3}, "min must be below max");
  refused("/cameras_in_world", 3, "must be an array");
  ExpectError<DataError>([] { ParseFieldWorld(nlohmann::json::array(), "world.json"); },
                         {"'input_from_world' is missing"});
}

}  // namespace
}  // namespace tetrec
