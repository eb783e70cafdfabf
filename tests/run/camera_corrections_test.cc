#include "run/camera_corrections.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

nlohmann::json ExampleCorrections() {
  return nlohmann::json::parse(R"({
    "schema": 1,
    "views": [{"name": "a.jpg", "rotation_deg": 0.5, "move": 0.01, "shift_px": 2.5,
               "cam_from_world": {"rotation": [[0, -1, 0], [1, 0, 0], [0, 0, 1]],
                                  "translation": [1, 2, 3]}},
              {"name": "b.jpg", "rotation_deg": 0, "move": 0, "shift_px": 0,
               "cam_from_world": {"rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
                                  "translation": [0, 0, 0]}}]})");
}

TEST(CameraCorrections, WhatWasWrittenIsReadBack) {
  const ScratchFolder folder;
  const std::vector<CameraCorrection> corrections =
      ParseCameraCorrections(ExampleCorrections(), "c.json");
  WriteCameraCorrections(folder / kCameraCorrectionsFile, corrections);
  EXPECT_EQ(ReadJson(folder / kCameraCorrectionsFile), ExampleCorrections());
  const std::vector<CameraCorrection> again =
      ReadCameraCorrections(folder / kCameraCorrectionsFile);
  ASSERT_EQ(again.size(), 2u);
  EXPECT_EQ(again[0].name, "a.jpg");
  EXPECT_EQ(again[0].cam_from_world * glm::dvec3(1, 0, 0), glm::dvec3(1, 3, 3));
  EXPECT_EQ(again[0].rotation_deg, 0.5);
  EXPECT_EQ(again[0].move, 0.01);
  EXPECT_EQ(again[0].shift_px, 2.5);
}

TEST(CameraCorrections, WhatCouldNotBeReadIsNotWritten) {
  const ScratchFolder folder;
  std::vector<CameraCorrection> corrections =
      ParseCameraCorrections(ExampleCorrections(), "c.json");
  corrections[1].cam_from_world.rotation[0][0] = -1;  // mirrors
  ExpectError<DataError>(
      [&] { WriteCameraCorrections(folder / kCameraCorrectionsFile, corrections); },
      {"cameras.json", "views[1].cam_from_world.rotation"});
  EXPECT_FALSE(std::filesystem::exists(folder / kCameraCorrectionsFile));
}

TEST(CameraCorrections, NamesTheBadField) {
  const auto refused = [](const std::string& path, const nlohmann::json& value,
                          const std::string& reason) {
    nlohmann::json file = ExampleCorrections();
    file[nlohmann::json::json_pointer(path)] = value;
    ExpectError<DataError>([&] { ParseCameraCorrections(file, "cameras.json"); },
                           {"cameras.json: " + reason});
  };
  refused("/schema", 2, "schema is 2; expected 1");
  refused("/views", 3, "views is 3; expected an array");
  refused("/views/1/name", "a.jpg", "views[1].name is \"a.jpg\" for the second time");
  refused("/views/0/rotation_deg", -1, "views[0].rotation_deg is -1; expected");
  refused("/views/0/move", "x", "views[0].move is \"x\"; expected a number");
  refused("/views/0/shift_px", 1e9, "views[0].shift_px is 1000000000.0; expected");
  refused("/views/0/cam_from_world/translation", {1, 2}, "views[0].cam_from_world.translation");
  refused("/views/0/cam_from_world/rotation/0/0", 1, "views[0].cam_from_world.rotation");
  ExpectError<DataError>([] { ParseCameraCorrections(nlohmann::json::array(), "cameras.json"); },
                         {"cameras.json: ", "expected an object"});
}

}  // namespace
}  // namespace tetrec
