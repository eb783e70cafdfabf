#include "run/field_world.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

nlohmann::json ExampleWorld() {
  return nlohmann::json::parse(R"({
    "schema": 1,
    "input_from_world": {"scale": 2, "rotation": [0, -1, 0, 1, 0, 0, 0, 0, 1], "translation": [1, 2, 3]},
    "subject_bounds": {"min": [-1, -1, -1], "max": [1, 1, 1]},
    "cameras_in_world": [[4, 5, 6]],
    "scene": "../1_scene"})");
}

TEST(FieldWorld, ReadsRotationsRowByRow) {
  const FieldWorld world = ParseFieldWorld(ExampleWorld(), "world.json");
  EXPECT_EQ(world.input_from_world * glm::dvec3(1, 0, 0), glm::dvec3(1, 4, 3));
  EXPECT_EQ(world.cameras_in_world.at(0), glm::dvec3(4, 5, 6));
  nlohmann::json nested = ExampleWorld();
  nested["input_from_world"]["rotation"] = {{0, -1, 0}, {1, 0, 0}, {0, 0, 1}};
  EXPECT_EQ(ParseFieldWorld(nested, "world.json").input_from_world * glm::dvec3(1, 0, 0),
            glm::dvec3(1, 4, 3));
}

TEST(FieldWorld, WhatWasWrittenIsReadBack) {
  const ScratchFolder folder;
  const FieldWorld world = ParseFieldWorld(ExampleWorld(), "world.json");
  WriteFieldWorld(folder / kFieldWorldFile, world);
  EXPECT_EQ(ReadJson(folder / kFieldWorldFile), ExampleWorld());
  const FieldWorld again = ReadFieldWorld(folder / kFieldWorldFile);
  EXPECT_EQ(again.input_from_world.scale, world.input_from_world.scale);
  EXPECT_EQ(again.input_from_world.rotation, world.input_from_world.rotation);
  EXPECT_EQ(again.input_from_world.translation, world.input_from_world.translation);
  EXPECT_EQ(again.subject_bounds.min, world.subject_bounds.min);
  EXPECT_EQ(again.subject_bounds.max, world.subject_bounds.max);
  EXPECT_EQ(again.cameras_in_world, world.cameras_in_world);
  EXPECT_EQ(again.scene, "../1_scene");
}

TEST(FieldWorld, WhatCouldNotBeReadIsNotWritten) {
  const ScratchFolder folder;
  FieldWorld world = ParseFieldWorld(ExampleWorld(), "world.json");
  world.cameras_in_world.push_back({0, NAN, 0});
  ExpectError<DataError>([&] { WriteFieldWorld(folder / kFieldWorldFile, world); },
                         {"world.json", "cameras_in_world[1][1]"});
  EXPECT_FALSE(std::filesystem::exists(folder / kFieldWorldFile));
}

TEST(FieldWorld, NamesTheBadField) {
  const auto refused = [](const std::string& path, const nlohmann::json& value,
                          const std::string& reason) {
    nlohmann::json world = ExampleWorld();
    world[nlohmann::json::json_pointer(path)] = value;
    ExpectError<DataError>([&] { ParseFieldWorld(world, "world.json"); },
                           {"world.json: " + reason});
  };
  refused("/schema", 2, "schema is 2; expected 1");
  refused("/input_from_world/scale", 0, "input_from_world.scale is 0; expected 1e-12 to");
  refused("/input_from_world/scale", "x", "input_from_world.scale is \"x\"; expected a number");
  refused("/input_from_world/rotation/0", 0.5, "input_from_world.rotation is not a rotation");
  refused("/input_from_world/rotation/8", -1, "input_from_world.rotation is not a rotation");
  refused("/input_from_world/rotation", {1, 2},
          "input_from_world.rotation has 2 items; expected 9 numbers or 3 rows");
  refused("/input_from_world/translation", {1, 2},
          "input_from_world.translation has 2 items; expected 3 numbers");
  refused("/subject_bounds/min", {1, 2, 3}, "subject_bounds is an empty box");
  refused("/cameras_in_world", 3, "cameras_in_world is 3; expected an array");
  refused("/cameras_in_world/0", {1, 2}, "cameras_in_world[0] has 2 items; expected 3 numbers");
  refused("/scene", 3, "scene is 3; expected text");
  nlohmann::json world = ExampleWorld();
  world.erase("input_from_world");
  ExpectError<DataError>([&] { ParseFieldWorld(world, "world.json"); },
                         {"world.json: input_from_world is missing"});
  ExpectError<DataError>([] { ParseFieldWorld(nlohmann::json::array(), "world.json"); },
                         {"world.json: ", "expected an object"});
}

}  // namespace
}  // namespace tetrec
