#include "run/photo_exposures.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

nlohmann::json ExampleExposures() {
  return nlohmann::json::parse(R"({
    "schema": 1,
    "views": [{"name": "a.jpg", "gain": [1.2, 1, 0.8], "offset": [0, 0.01, -0.01]},
              {"name": "b.jpg", "gain": [0.8, 1, 1.25], "offset": [0, -0.01, 0.01]}]})");
}

TEST(PhotoExposures, WhatWasWrittenIsReadBack) {
  const ScratchFolder folder;
  const std::vector<PhotoExposure> exposures =
      ParsePhotoExposures(ExampleExposures(), "exposure.json");
  WritePhotoExposures(folder / kPhotoExposuresFile, exposures);
  EXPECT_EQ(ReadJson(folder / kPhotoExposuresFile), ExampleExposures());
  const std::vector<PhotoExposure> again = ReadPhotoExposures(folder / kPhotoExposuresFile);
  ASSERT_EQ(again.size(), 2u);
  EXPECT_EQ(again[1].name, "b.jpg");
  EXPECT_EQ(again[1].gain, glm::dvec3(0.8, 1, 1.25));
  EXPECT_EQ(again[1].offset, glm::dvec3(0, -0.01, 0.01));
}

TEST(PhotoExposures, WhatCouldNotBeReadIsNotWritten) {
  const ScratchFolder folder;
  std::vector<PhotoExposure> exposures = ParsePhotoExposures(ExampleExposures(), "exposure.json");
  exposures[1].gain.g = NAN;
  ExpectError<DataError>([&] { WritePhotoExposures(folder / kPhotoExposuresFile, exposures); },
                         {"exposure.json", "views[1].gain[1]"});
  EXPECT_FALSE(std::filesystem::exists(folder / kPhotoExposuresFile));
}

TEST(PhotoExposures, NamesTheBadField) {
  const auto refused = [](const std::string& path, const nlohmann::json& value,
                          const std::string& reason) {
    nlohmann::json file = ExampleExposures();
    file[nlohmann::json::json_pointer(path)] = value;
    ExpectError<DataError>([&] { ParsePhotoExposures(file, "exposure.json"); },
                           {"exposure.json: " + reason});
  };
  refused("/schema", 2, "schema is 2; expected 1");
  refused("/views", 3, "views is 3; expected an array");
  refused("/views/0/name", 3, "views[0].name is 3; expected text");
  refused("/views/1/name", "a.jpg", "views[1].name is \"a.jpg\" for the second time");
  refused("/views/0/gain", {1, 2}, "views[0].gain has 2 items; expected 3 numbers");
  refused("/views/0/gain/2", 0, "views[0].gain[2] is 0; expected");
  refused("/views/0/gain/2", -1, "views[0].gain[2] is -1; expected");
  refused("/views/0/gain/2", 1e9, "views[0].gain[2] is 1000000000.0; expected");
  refused("/views/0/offset/0", "x", "views[0].offset[0] is \"x\"; expected a number");
  refused("/views/0/offset/0", 11, "views[0].offset[0] is 11; expected");
  nlohmann::json file = ExampleExposures();
  file["views"][0].erase("offset");
  ExpectError<DataError>([&] { ParsePhotoExposures(file, "exposure.json"); },
                         {"exposure.json: views[0].offset is missing"});
  ExpectError<DataError>([] { ParsePhotoExposures(nlohmann::json::array(), "exposure.json"); },
                         {"exposure.json: ", "expected an object"});
}

TEST(PhotoExposures, AreUnevenFromATenthInGainOrATwentiethInOffset) {
  EXPECT_FALSE(IsUneven({"a", {1.09, 0.91, 1}, {0.04, -0.04, 0}}));
  EXPECT_TRUE(IsUneven({"a", {1, 1.11, 1}, glm::dvec3(0)}));
  EXPECT_TRUE(IsUneven({"a", {1, 1, 0.89}, glm::dvec3(0)}));
  EXPECT_TRUE(IsUneven({"a", glm::dvec3(1), {0, 0, -0.06}}));
}

}  // namespace
}  // namespace tetrec
