#include "scene/transforms.h"

#include "core/error.h"
#include "expect_error.h"
#include "geometry/camera.h"
#include "geometry/rotation.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>

namespace tetrec {
namespace {

using Json = nlohmann::json;

// World from camera, OpenGL axes: a camera at (4, 0.5, 1) whose right is world y, up is world z and
// whose back is world x, so that it looks along -x.
const Json kPose = {{0, 0, 1, 4}, {1, 0, 0, 0.5}, {0, 1, 0, 1}, {0, 0, 0, 1}};

Json Transforms(const std::vector<std::string>& files) {
  Json json = {{"camera_angle_x", 0.7}, {"frames", Json::array()}};
  for (const std::string& file : files) {
    json["frames"].push_back({{"file_path", file}, {"transform_matrix", kPose}});
  }
  return json;
}

// A folder of three splits; pictures are only looked for, not read.
void WriteGoodSet(const ScratchFolder& folder) {
  for (const char* file : {"train/r_0.png", "train/r_1.png", "val/r_0.jpg", "test/r_0.png",
                           "test/r_0_depth_0001.png", "train/not_listed.png"}) {
    folder.Write(file, "");
  }
  folder.Write("transforms_train.json", Transforms({"./train/r_0", "./train/r_1"}).dump());
  folder.Write("transforms_val.json", Transforms({"val/r_0.jpg"}).dump());
  folder.Write("transforms_test.json", Transforms({"./test/r_0"}).dump());
}

TEST(NerfSynthetic, ListsWhatTheJsonListsAndNothingElse) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  const Dataset set = ReadNerfSynthetic(folder.path());
  ASSERT_EQ(set.pictures.size(), 4u);
  const char* names[] = {"train/r_0", "train/r_1", "val/r_0", "test/r_0"};
  const Split splits[] = {Split::kTrain, Split::kTrain, Split::kValidation, Split::kTest};
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(set.pictures[i].name, names[i]);
    EXPECT_EQ(set.pictures[i].split, splits[i]);
    EXPECT_EQ(set.pictures[i].horizontal_fov_rad, 0.7);
    EXPECT_TRUE(std::filesystem::exists(set.pictures[i].file)) << set.pictures[i].file;
  }
  EXPECT_EQ(set.pictures[2].file.extension(), ".jpg");
  EXPECT_TRUE(set.missing_files.empty());
}

TEST(NerfSynthetic, TurnsOpenGlAxesIntoOurs) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  const Rigid3 cam_from_input = ReadNerfSynthetic(folder.path()).pictures[0].cam_from_input;
  EXPECT_LT(DistanceFromRotation(cam_from_input.rotation), 1e-15);
  // By hand: 3 before the camera, 0.25 to its right and 0.5 above it.
  const glm::dvec3 point_in_input(1, 0.75, 1.5);
  EXPECT_LT(glm::length(cam_from_input * point_in_input - glm::dvec3(0.25, -0.5, 3)), 1e-15);
  const Camera camera{100, 100, 60, 60, 50, 50};
  const glm::dvec2 pixel = camera.ImageFromCam(cam_from_input * point_in_input);
  EXPECT_NEAR(pixel.x, 50 + 60 * 0.25 / 3, 1e-12);
  EXPECT_NEAR(pixel.y, 50 - 60 * 0.5 / 3, 1e-12);  // above the middle
}

TEST(NerfSynthetic, NotesMissingHeldOutSplits) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  std::filesystem::remove(folder / "transforms_val.json");
  const Dataset set = ReadNerfSynthetic(folder.path());
  EXPECT_EQ(set.pictures.size(), 3u);
  EXPECT_EQ(set.missing_files, std::vector<std::string>{"transforms_val.json"});
}

TEST(NerfSynthetic, MakesRoundedPosesOrthonormal) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  Json json = Transforms({"train/r_0"});
  const double c = std::cos(0.3), s = std::sin(0.3);
  const auto rounded = [](double value) { return std::round(value * 1e6) / 1e6; };
  json["frames"][0]["transform_matrix"] = {
      {rounded(c), rounded(-s), 0, 1}, {rounded(s), rounded(c), 0, 2}, {0, 0, 1, 3}, {0, 0, 0, 1}};
  folder.Write("transforms_train.json", json.dump());
  const Rigid3 pose = ReadNerfSynthetic(folder.path()).pictures[0].cam_from_input;
  EXPECT_LT(DistanceFromRotation(pose.rotation), 1e-15);
  EXPECT_LT(glm::length(pose * glm::dvec3(1, 2, 3)), 1e-5);  // the camera's own place
}

TEST(NerfSynthetic, RefusesEveryBrokenFieldByName) {
  struct Case {
    const char* message;
    std::function<void(Json&)> spoil;
  };
  const Case cases[] = {
      {"camera_angle_x is missing", [](Json& j) { j.erase("camera_angle_x"); }},
      {"camera_angle_x is 0", [](Json& j) { j["camera_angle_x"] = 0; }},
      {"camera_angle_x is 40", [](Json& j) { j["camera_angle_x"] = 40; }},
      {"camera_angle_x is \"wide\"", [](Json& j) { j["camera_angle_x"] = "wide"; }},
      {"frames is missing", [](Json& j) { j.erase("frames"); }},
      {"frames is empty", [](Json& j) { j["frames"] = Json::array(); }},
      {"frames is an object", [](Json& j) { j["frames"] = Json::object(); }},
      {"frames[1].file_path is missing", [](Json& j) { j["frames"][1].erase("file_path"); }},
      {"frames[1].file_path names a missing picture",
       [](Json& j) { j["frames"][1]["file_path"] = "./train/r_7"; }},
      {"frames[1].file_path names a missing picture",
       [](Json& j) { j["frames"][1]["file_path"] = std::string(5000, 'x'); }},
      {"frames[1].file_path is \"../secret\"",
       [](Json& j) { j["frames"][1]["file_path"] = "./train/../../secret"; }},
      {"frames[1].file_path is \"/etc/passwd\"",
       [](Json& j) { j["frames"][1]["file_path"] = "/etc/passwd"; }},
      {"picture \"train/r_0\"", [](Json& j) { j["frames"][1]["file_path"] = "train/r_0.png"; }},
      {"frames[0].transform_matrix is missing",
       [](Json& j) { j["frames"][0].erase("transform_matrix"); }},
      {"transform_matrix has 3 rows", [](Json& j) { j["frames"][0]["transform_matrix"].erase(3); }},
      {"transform_matrix[1] has 3 items",
       [](Json& j) { j["frames"][0]["transform_matrix"][1].erase(3); }},
      {"transform_matrix[2][3] is null",
       [](Json& j) { j["frames"][0]["transform_matrix"][2][3] = std::nan(""); }},
      {"transform_matrix[3] is not 0 0 0 1",
       [](Json& j) { j["frames"][0]["transform_matrix"][3][0] = 0.5; }},
      {"transform_matrix is no rigid pose",
       [](Json& j) { j["frames"][0]["transform_matrix"][0][2] = 1.01; }},
      {"transform_matrix is no rigid pose",
       [](Json& j) { j["frames"][0]["transform_matrix"][0][2] = -1; }},
  };
  const ScratchFolder folder;
  WriteGoodSet(folder);
  for (const Case& broken : cases) {
    SCOPED_TRACE(broken.message);
    Json json = Transforms({"./train/r_0", "./train/r_1"});
    broken.spoil(json);
    folder.Write("transforms_train.json", json.dump());
    ExpectError<DataError>([&] { ReadNerfSynthetic(folder.path()); },
                           {folder.path().string(), broken.message});
  }
}

TEST(NerfSynthetic, RefusesNanAndOtherBrokenJson) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  // As Python writes it.
  folder.Write("transforms_train.json", "{\"camera_angle_x\": NaN, \"frames\": []}");
  ExpectError<DataError>([&] { ReadNerfSynthetic(folder.path()); }, {"transforms_train.json"});
}

TEST(NerfSynthetic, SaysWhenTheFolderIsNotOne) {
  const ScratchFolder folder;
  ExpectError<DataError>([&] { ReadNerfSynthetic(folder / "none"); }, {"none", "no such folder"});
  ExpectError<DataError>([&] { ReadNerfSynthetic(folder.path()); }, {"no transforms_train.json"});
}

}  // namespace
}  // namespace tetrec
