#include "import/transforms.h"

#include "core/error.h"
#include "core/log.h"
#include "expect_error.h"
#include "geometry/camera.h"
#include "geometry/lens.h"
#include "geometry/rotation.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>

namespace tetrec {
namespace {

using Json = nlohmann::json;

// World from camera, with OpenGL axes: a camera at (4, 0.5, 1) whose right is world y, whose up is
// world z and whose back is world x, so that it looks along -x.
const Json kPose = {{0, 0, 1, 4}, {1, 0, 0, 0.5}, {0, 1, 0, 1}, {0, 0, 0, 1}};

Json Transforms(const std::vector<std::string>& files) {
  Json json = {{"camera_angle_x", 0.7}, {"frames", Json::array()}};
  for (const std::string& file : files) {
    json["frames"].push_back({{"file_path", file}, {"transform_matrix", kPose}});
  }
  return json;
}

// A folder of three splits; the images only need to exist and are not read.
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

TEST(NerfSynthetic, ConvertsOpenGlAxes) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  const Rigid3 cam_from_input = ReadNerfSynthetic(folder.path()).pictures[0].cam_from_input;
  EXPECT_LT(DistanceFromRotation(cam_from_input.rotation), 1e-15);
  // Computed by hand: 3 in front of the camera, 0.25 to its right and 0.5 above it.
  const glm::dvec3 point_in_input(1, 0.75, 1.5);
  EXPECT_LT(glm::length(cam_from_input * point_in_input - glm::dvec3(0.25, -0.5, 3)), 1e-15);
  const Camera camera{100, 100, 60, 60, 50, 50};
  const glm::dvec2 pixel = camera.ImageFromCam(cam_from_input * point_in_input);
  EXPECT_NEAR(pixel.x, 50 + 60 * 0.25 / 3, 1e-12);
  EXPECT_NEAR(pixel.y, 50 - 60 * 0.5 / 3, 1e-12);  // above the middle
}

TEST(NerfSynthetic, TakesViewsOfValidationAndTestForTestViews) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  folder.Write("transforms_val.json", Transforms({"val/r_0.jpg", "test/r_0.png"}).dump());
  const Dataset set = ReadNerfSynthetic(folder.path());
  ASSERT_EQ(set.pictures.size(), 4u);
  EXPECT_EQ(set.pictures[2].name, "val/r_0");
  EXPECT_EQ(set.pictures[2].split, Split::kValidation);
  EXPECT_EQ(set.pictures[3].name, "test/r_0");
  EXPECT_EQ(set.pictures[3].split, Split::kTest);
}

TEST(NerfSynthetic, RefusesAViewThatIsListedTwice) {
  struct Case {
    const char* file;
    std::vector<std::string> frames;
    const char* message;
  };
  const Case cases[] = {
      {"transforms_val.json", {"train/r_1"}, "is in transforms_train.json already"},
      {"transforms_test.json",
       {"train/r_1"},
       "is in transforms_train.json already; a view may be listed only once; remove "
       "transforms_test.json to hold out every 8th view"},
      {"transforms_val.json", {"val/r_0", "val/r_0.jpg"}, "is in transforms_val.json already"},
      {"transforms_test.json", {"val/r_0", "val/r_0.jpg"}, "is in transforms_test.json already"}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.message);
    const ScratchFolder folder;
    WriteGoodSet(folder);
    folder.Write(c.file, Transforms(c.frames).dump());
    ExpectError<DataError>([&] { ReadNerfSynthetic(folder.path()); }, {c.file, c.message});
  }
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
      {"frames[0] has no focal length", [](Json& j) { j.erase("camera_angle_x"); }},
      {"camera_angle_x is 0", [](Json& j) { j["camera_angle_x"] = 0; }},
      {"camera_angle_x is 40", [](Json& j) { j["camera_angle_x"] = 40; }},
      {"camera_angle_x is \"wide\"", [](Json& j) { j["camera_angle_x"] = "wide"; }},
      {"frames is missing", [](Json& j) { j.erase("frames"); }},
      {"frames is empty", [](Json& j) { j["frames"] = Json::array(); }},
      {"frames is an object", [](Json& j) { j["frames"] = Json::object(); }},
      {"frames[1].file_path is missing", [](Json& j) { j["frames"][1].erase("file_path"); }},
      {"1 of 4 images are missing, both as written and with .png, .jpg",
       [](Json& j) { j["frames"][1]["file_path"] = "./train/r_7"; }},
      {"1 of 4 images are missing, both as written and with .png, .jpg",
       [](Json& j) { j["frames"][1]["file_path"] = std::string(5000, 'x'); }},
      {"frames[1].file_path is \"../secret\"",
       [](Json& j) { j["frames"][1]["file_path"] = "./train/../../secret"; }},
      {"frames[1].file_path is \"/etc/passwd\"",
       [](Json& j) { j["frames"][1]["file_path"] = "/etc/passwd"; }},
      {"image \"train/r_0\"", [](Json& j) { j["frames"][1]["file_path"] = "train/r_0.png"; }},
      {"frames[0].transform_matrix is missing",
       [](Json& j) { j["frames"][0].erase("transform_matrix"); }},
      {"transform_matrix has 2 rows",
       [](Json& j) {
         j["frames"][0]["transform_matrix"].erase(3);
         j["frames"][0]["transform_matrix"].erase(2);
       }},
      {"transform_matrix[1] has 3 items",
       [](Json& j) { j["frames"][0]["transform_matrix"][1].erase(3); }},
      {"transform_matrix[2][3] is null",
       [](Json& j) { j["frames"][0]["transform_matrix"][2][3] = std::nan(""); }},
      {"transform_matrix[3] is not 0 0 0 1",
       [](Json& j) { j["frames"][0]["transform_matrix"][3][0] = 0.5; }},
      {"transform_matrix is not a rigid pose",
       [](Json& j) { j["frames"][0]["transform_matrix"][0][2] = 1.01; }},
      {"transform_matrix is not a rigid pose",
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

TEST(NerfSynthetic, NamesAllMissingImagesOfAllFilesAtOnce) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  std::filesystem::remove(folder / "train/r_1.png");
  std::filesystem::remove(folder / "val/r_0.jpg");
  ExpectError<DataError>(
      [&] { ReadNerfSynthetic(folder.path()); },
      {"2 of 4 images are missing", ": train/r_1, val/r_0.jpg; ",
       "copy them there, or skip missing images",
       "tetrec-sfm finds new cameras for the images in " + (folder / "train").string()});
  const Dataset set = ReadNerfSynthetic(folder.path(), {.missing = MissingPictures::kSkip});
  ASSERT_EQ(set.pictures.size(), 2u);
  EXPECT_EQ(set.pictures[0].name, "train/r_0");
  EXPECT_EQ(set.pictures[1].name, "test/r_0");
  EXPECT_EQ(set.skipped, (std::vector<std::string>{"train/r_1", "val/r_0.jpg"}));
}

TEST(NerfSynthetic, SkippingLeavesATrainingView) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  for (const char* file : {"train/r_0.png", "train/r_1.png"}) {
    std::filesystem::remove(folder / file);
  }
  const auto skip = [&] { ReadNerfSynthetic(folder.path(), {.missing = MissingPictures::kSkip}); };
  ExpectError<DataError>(skip, {"without the missing images there is no view to train on", "2 of 4",
                                "train/r_0, train/r_1"});
  // If all listed images are missing, there may be others.
  for (const char* file : {"val/r_0.jpg", "test/r_0.png", "test/r_0_depth_0001.png"}) {
    std::filesystem::remove(folder / file);
  }
  ExpectError<DataError>(
      skip, {"4 of 4 images are missing", "copy them there", "skipping missing", "tetrec-sfm"});
  std::filesystem::remove(folder / "train/not_listed.png");
  try {
    skip();
    ADD_FAILURE() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("tetrec-sfm")));
  }
}

TEST(NerfSynthetic, RefusesNanAndOtherBrokenJson) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  // Python writes NaN like this.
  folder.Write("transforms_train.json", "{\"camera_angle_x\": NaN, \"frames\": []}");
  ExpectError<DataError>([&] { ReadNerfSynthetic(folder.path()); }, {"transforms_train.json"});
}

TEST(NerfSynthetic, RefusesAFolderThatIsNotADataSet) {
  const ScratchFolder folder;
  ExpectError<DataError>([&] { ReadNerfSynthetic(folder / "none"); }, {"none", "no such folder"});
  ExpectError<DataError>([&] { ReadNerfSynthetic(folder.path()); }, {"no transforms_train.json"});
}

// transforms.json of instant-ngp or nerfstudio with two frames that share a lens.
Json OneFile() {
  Json json = Transforms({"./images/a.jpg", "images/b.jpg"});
  json.erase("camera_angle_x");
  json.update({{"w", 40}, {"h", 30.0}, {"fl_x", 50}, {"fl_y", 51}, {"cx", 19}, {"cy", 16}});
  return json;
}

Dataset ReadOneFile(const ScratchFolder& folder, const Json& json) {
  for (const char* file : {"images/a.jpg", "images/b.jpg", "masks/a.png"}) folder.Write(file, "");
  folder.Write("transforms.json", json.dump());
  return ReadTransforms(folder.path());
}

Json With(Json json, const Json& fields) {
  json.update(fields);
  return json;
}

TEST(Transforms, TakeTheLensFromTheFileOrTheFrame) {
  const ScratchFolder folder;
  Json json = OneFile();
  json["frames"][1]["fl_x"] = 60;
  json["frames"][1]["cx"] = 20.5;
  const Dataset set = ReadOneFile(folder, json);
  ASSERT_EQ(set.pictures.size(), 2u);
  EXPECT_FALSE(set.has_split);
  EXPECT_EQ(set.pictures[0].name, "images/a");
  EXPECT_EQ(set.pictures[0].file, folder / "images/a.jpg");
  EXPECT_EQ(set.pictures[0].lens.model, LensModel::kPinhole);
  EXPECT_EQ(set.pictures[0].lens.width, 40u);
  EXPECT_EQ(set.pictures[0].lens.height, 30u);
  EXPECT_EQ(set.pictures[0].lens.params, (std::vector<double>{50, 51, 19, 16}));
  // A frame that specifies one focal length specifies it for both axes.
  EXPECT_EQ(set.pictures[1].lens.params, (std::vector<double>{60, 60, 20.5, 16}));
}

TEST(Transforms, AFramesFieldOfViewComesBeforeTheFilesFocalLength) {
  const ScratchFolder folder;
  Json json = OneFile();
  json["frames"][1]["camera_angle_x"] = 1.0;
  const std::vector<double> params = ReadOneFile(folder, json).pictures[1].lens.params;
  EXPECT_NEAR(params[0], 20 / std::tan(0.5), 1e-12);
  EXPECT_NEAR(params[1], 20 / std::tan(0.5), 1e-12);
}

TEST(Transforms, SpecifyTheFocalLengthInFourWaysAndTheMiddleByDefault) {
  const ScratchFolder folder;
  Json bare = OneFile();
  for (const char* name : {"fl_x", "fl_y", "cx", "cy"}) bare.erase(name);
  const double angle = 2 * std::atan(0.4), degrees = angle * 180 / 3.14159265358979323846;
  const auto params = [&](const Json& fields) {
    return ReadOneFile(folder, With(bare, fields)).pictures[0].lens.params;
  };
  // A focal length of 50 px for 40 px means that the tangent of half the angle is 0.4.
  const auto expect = [](const std::vector<double>& found, const std::vector<double>& wanted) {
    ASSERT_EQ(found.size(), wanted.size());
    for (size_t i = 0; i < wanted.size(); ++i) EXPECT_NEAR(found[i], wanted[i], 1e-12) << i;
  };
  expect(params({{"fl_x", 50}}), {50, 50, 20, 15});
  expect(params({{"fl_y", 50}}), {50, 50, 20, 15});
  expect(params({{"camera_angle_x", angle}}), {50, 50, 20, 15});
  expect(params({{"x_fov", degrees}}), {50, 50, 20, 15});
  expect(params({{"camera_angle_y", angle}}), {37.5, 37.5, 20, 15});
  expect(params({{"camera_angle_x", angle}, {"y_fov", degrees}}), {50, 37.5, 20, 15});
  expect(params({{"camera_angle_x", 0.1}, {"fl_x", 50}}), {50, 50, 20, 15});
}

TEST(Transforms, WithoutASizeKeepTheFieldsOfView) {
  const ScratchFolder folder;
  Json json = Transforms({"images/a.jpg"});
  json["camera_angle_y"] = 0.5;
  const PosedPicture picture = ReadOneFile(folder, json).pictures[0];
  EXPECT_EQ(picture.lens.width, 0u);
  EXPECT_EQ(picture.horizontal_fov_rad, 0.7);
  EXPECT_EQ(picture.vertical_fov_rad, 0.5);
}

TEST(Transforms, GiveEachDistortionItsModel) {
  const ScratchFolder folder;
  const auto lens = [&](const Json& fields) {
    return ReadOneFile(folder, With(OneFile(), fields)).pictures[0].lens;
  };
  struct Case {
    Json fields;
    LensModel model;
    std::vector<double> coefficients;
  };
  const Case cases[] = {
      {{{"k1", 0}, {"k2", 0.0}, {"p1", 0}, {"p2", 0}, {"camera_model", "OPENCV"}},
       LensModel::kPinhole,
       {}},
      {{{"camera_model", "SIMPLE_PINHOLE"}, {"is_fisheye", false}}, LensModel::kPinhole, {}},
      {{{"k1", 0.1}}, LensModel::kOpenCv, {0.1, 0, 0, 0}},
      {{{"k1", "-0.1"}, {"k2", "2e-3"}, {"p1", "0"}}, LensModel::kOpenCv, {-0.1, 0.002, 0, 0}},
      {{{"k1", 0.1}, {"k2", 0.2}, {"p1", 0.3}, {"p2", 0.4}, {"k3", 0}, {"k4", 0}},
       LensModel::kOpenCv,
       {0.1, 0.2, 0.3, 0.4}},
      {{{"k1", 0.1}, {"k2", 0.2}, {"p1", 0.3}, {"p2", 0.4}, {"k3", 0.5}},
       LensModel::kFullOpenCv,
       {0.1, 0.2, 0.3, 0.4, 0.5, 0, 0, 0}},
      {{{"camera_model", "OPENCV_FISHEYE"}}, LensModel::kOpenCvFisheye, {0, 0, 0, 0}},
      {{{"is_fisheye", true}, {"k1", 0.1}, {"k2", 0.2}, {"k3", 0.3}, {"k4", 0.4}},
       LensModel::kOpenCvFisheye,
       {0.1, 0.2, 0.3, 0.4}},
      {{{"is_fisheye", true}, {"k1", 0.1}, {"k2", 0.2}, {"k3", 0.3}, {"k4", 0.4}, {"p2", 0.5}},
       LensModel::kThinPrismFisheye,
       {0.1, 0.2, 0, 0.5, 0.3, 0.4, 0, 0}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.fields.dump());
    std::vector<double> params = {50, 51, 19, 16};
    params.insert(params.end(), c.coefficients.begin(), c.coefficients.end());
    EXPECT_EQ(lens(c.fields).model, c.model);
    EXPECT_EQ(lens(c.fields).params, params);
  }
}

// Metashape's fisheyes have p1 and p2, as nerfstudio writes them.
TEST(Transforms, SkewedFisheyesAreThoseOfNerfstudio) {
  const ScratchFolder folder;
  const auto lens = [&](double p1, double p2) {
    const Json fields = {{"is_fisheye", true}, {"k1", 0.01}, {"k2", 0.02}, {"k3", 0.03},
                         {"k4", 0.04},         {"p1", p1},   {"p2", p2}};
    return ReadOneFile(folder, With(OneFile(), fields)).pictures[0].lens;
  };
  Lens straight = lens(0.001, 0);
  ASSERT_EQ(straight.model, LensModel::kThinPrismFisheye);
  straight.params[6] = 0;
  for (const glm::dvec2 direction : {glm::dvec2(0.4, -0.3), glm::dvec2(-0.9, 0.2)}) {
    EXPECT_LT(glm::distance(DistortedImageFromCam(straight, direction),
                            DistortedImageFromCam(lens(0, 0), direction)),
              1e-12);
    // nerfstudio's formula.
    const double p1 = 0.001, p2 = -0.002, radius = glm::length(direction);
    const glm::dvec2 bent = direction * (std::atan(radius) / radius);
    const double xy = bent.x * bent.y, r2 = glm::dot(bent, bent);
    const double over = 1 + r2 * (0.01 + r2 * (0.02 + r2 * (0.03 + r2 * 0.04)));
    const glm::dvec2 distorted = {bent.x * over + 2 * p1 * xy + p2 * (r2 + 2 * bent.x * bent.x),
                                  bent.y * over + 2 * p2 * xy + p1 * (r2 + 2 * bent.y * bent.y)};
    EXPECT_LT(glm::distance(DistortedImageFromCam(lens(p1, p2), direction),
                            glm::dvec2(50, 51) * distorted + glm::dvec2(19, 16)),
              1e-12);
  }
}

TEST(Transforms, TakeNerfstudiosListOfCoefficients) {
  const ScratchFolder folder;
  const Json list = {0.1, 0.2, 0.3, 0, 0.4, 0.5};  // k1 k2 k3 k4 p1 p2
  Json json = With(OneFile(), {{"distortion_params", list}, {"k1", 0.9}});
  json["frames"][1]["k2"] = 0.7;  // has a coefficient, so the file's list does not apply
  const Dataset set = ReadOneFile(folder, json);
  EXPECT_EQ(set.pictures[0].lens.model, LensModel::kFullOpenCv);
  EXPECT_EQ(set.pictures[0].lens.params,
            (std::vector<double>{50, 51, 19, 16, 0.1, 0.2, 0.4, 0.5, 0.3, 0, 0, 0}));
  EXPECT_EQ(set.pictures[1].lens.params, (std::vector<double>{50, 51, 19, 16, 0.9, 0.7, 0, 0}));

  json["camera_model"] = "OPENCV_FISHEYE";
  json["distortion_params"] = {0.1, 0.2, 0.3, 0.4, 0, 0};
  json["frames"][1]["distortion_params"] = {0.5, 0.6, 0.7, 0.8, 0, 0};
  const Dataset fisheyes = ReadOneFile(folder, json);
  EXPECT_EQ(fisheyes.pictures[0].lens.model, LensModel::kOpenCvFisheye);
  EXPECT_EQ(fisheyes.pictures[0].lens.params,
            (std::vector<double>{50, 51, 19, 16, 0.1, 0.2, 0.3, 0.4}));
  EXPECT_EQ(fisheyes.pictures[1].lens.params,
            (std::vector<double>{50, 51, 19, 16, 0.5, 0.6, 0.7, 0.8}));
}

// The lines that a call logs.
template <class Body>
std::string LogOf(const Body& body) {
  ::testing::internal::CaptureStderr();
  body();
  return ::testing::internal::GetCapturedStderr();
}

TEST(Transforms, ListUnreadFieldsOnce) {
  const ScratchFolder folder;
  Json json = With(OneFile(), {{"applied_scale", 0.5},
                               {"aabb_scale", 4},
                               {"rolling_shutter", {0, 0, 0.0}},
                               {"from_na", false},
                               {"normal_mts_args", nullptr},
                               {"white_transparent", false},
                               {"bad\nname", 1}});
  for (Json& frame : json["frames"]) frame.update({{"sharpness", 2}, {"colmap_im_id", 1}});
  TakeWarnings();
  const std::string log = LogOf([&] { ReadOneFile(folder, json); });
  EXPECT_THAT(log, ::testing::HasSubstr("unused fields: applied_scale, bad?name, "
                                        "frames[].colmap_im_id, frames[].sharpness\n"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1) << log;
  EXPECT_TRUE(TakeWarnings().empty());
  EXPECT_EQ(LogOf([&] { ReadOneFile(folder, OneFile()); }), "");
}

TEST(Transforms, WarnAboutTransparencyThatIsNotRead) {
  const ScratchFolder folder;
  folder.Write("images/a.alpha.jpg", "");
  folder.Write("images/b.jpg.alpha.jpg", "");
  folder.Write("images/dynamic_mask_b.png", "");
  folder.Write("images/rays_a.dat", "");
  TakeWarnings();
  ReadOneFile(folder, With(OneFile(), {{"white_transparent", true}, {"black_transparent", true}}));
  using ::testing::HasSubstr;
  EXPECT_THAT(TakeWarnings(), ::testing::ElementsAre(
                                  HasSubstr("(NAME.alpha.png): 2; not used"),
                                  HasSubstr("(dynamic_mask_NAME): 1; not used"),
                                  HasSubstr("(rays_NAME.dat): 1; not used"),
                                  HasSubstr("black_transparent, white_transparent is not used")));
}

TEST(Transforms, SkipMissingImagesInSplitListsToo) {
  const ScratchFolder folder;
  Json json = OneFile();
  json["frames"].push_back(json["frames"][0]);
  json["frames"][2].update({{"file_path", "images/gone.jpg"}, {"mask_path", "masks/gone.png"}});
  json.update({{"train_filenames", {"images/a.jpg", "images/gone.jpg"}},
               {"test_filenames", {"images/b.jpg"}}});
  ExpectError<DataError>(
      [&] { ReadOneFile(folder, json); },
      {"1 of 3 images are missing", ": images/gone.jpg; copy them there, or skip"});
  const Dataset set = ReadTransforms(folder.path(), {.missing = MissingPictures::kSkip});
  ASSERT_EQ(set.pictures.size(), 2u);
  EXPECT_EQ(set.pictures[1].split, Split::kTest);
  EXPECT_EQ(set.skipped, std::vector<std::string>{"images/gone.jpg"});
}

TEST(Transforms, ReadPathsAsWindowsWritesThem) {
  const ScratchFolder folder;
  Json json = OneFile();
  json["frames"][0]["file_path"] = "images\\a.jpg";
  EXPECT_EQ(ReadOneFile(folder, json).pictures[0].file, folder / "images/a.jpg");
  json["frames"][0]["file_path"] = "images\\..\\..\\a.jpg";
  ExpectError<DataError>([&] { ReadOneFile(folder, json); }, {"file_path is \"../a.jpg\""});
}

TEST(Transforms, ThreeRowsOfAMatrixAreEnough) {
  const ScratchFolder folder;
  Json json = OneFile();
  json["frames"][1]["transform_matrix"].erase(3);
  const Dataset set = ReadOneFile(folder, json);
  EXPECT_EQ(set.pictures[0].cam_from_input.translation, set.pictures[1].cam_from_input.translation);
  EXPECT_EQ(set.pictures[0].cam_from_input.rotation, set.pictures[1].cam_from_input.rotation);
}

TEST(Transforms, FindImagesWithoutExtension) {
  const ScratchFolder folder;
  for (const char* extension : {".png", ".jpg", ".jpeg", ".PNG", ".JPG", ".JPEG", ".exr"}) {
    const std::string name = std::string("p/v1.") + extension[1] + std::to_string(extension[2]);
    folder.Write(name + extension, "");
    Json json = OneFile();
    json["frames"][0]["file_path"] = name;
    const PosedPicture picture = ReadOneFile(folder, json).pictures[0];
    EXPECT_EQ(picture.file, folder / (name + extension));
    EXPECT_EQ(picture.name, name);
    std::filesystem::remove(picture.file);
  }
}

TEST(Transforms, KeepTheExtensionsOfImagesThatDifferInNothingElse) {
  const ScratchFolder folder;
  folder.Write("images/a.png", "");
  Json json = OneFile();
  json["frames"].push_back(json["frames"][0]);
  json["frames"][2]["file_path"] = "images/a.png";
  ReadOneFile(folder, json);
  for (const char* place : {"", "/", "/."}) {
    const Dataset set = ReadDataset(folder.path().string() + place, DatasetFormat::kTransforms);
    ASSERT_EQ(set.pictures.size(), 3u);
    EXPECT_EQ(set.pictures[0].name, "images/a.jpg");
    EXPECT_EQ(set.pictures[1].name, "images/b.jpg");
    EXPECT_EQ(set.pictures[2].name, "images/a.png");
    EXPECT_EQ(set.pictures[0].image, "images/images/a.jpg.png");
    EXPECT_EQ(set.pictures[2].image, "images/images/a.png.png");
  }
}

TEST(Transforms, TakeATimeStampBehindADotForPartOfTheName) {
  const ScratchFolder folder;
  Json json = OneFile();
  for (const int i : {0, 1}) {
    const std::string file = "images/frame.000" + std::to_string(i);
    folder.Write(file + ".png", "");
    json["frames"][size_t(i)]["file_path"] = i == 0 ? file : file + ".png";
  }
  ReadOneFile(folder, json);
  const Dataset set = ReadDataset(folder.path(), DatasetFormat::kTransforms);
  EXPECT_EQ(set.pictures[0].name, "images/frame.0000");
  EXPECT_EQ(set.pictures[1].name, "images/frame.0001");
  EXPECT_EQ(set.pictures[1].image, "images/images/frame.0001.png");
}

TEST(Transforms, NameMasksAndIgnoreDepthsAndUnknownKeys) {
  const ScratchFolder folder;
  Json json = With(OneFile(), {{"applied_scale", 0.5}, {"applied_transform", kPose}});
  json["frames"][0].update(
      {{"mask_path", "./masks/a.png"}, {"depth_file_path", "d/none.png"}, {"sharpness", 12.5}});
  const Dataset set = ReadOneFile(folder, json);
  EXPECT_EQ(set.pictures[0].mask, folder / "masks/a.png");
  EXPECT_TRUE(set.pictures[1].mask.empty());
  EXPECT_EQ(set.pictures[0].cam_from_input.translation, set.pictures[1].cam_from_input.translation);
}

constexpr const char* kTwoPoints =
    "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
    "property float z\nproperty uint8 red\nproperty uint8 green\nproperty uint8 blue\nend_header\n"
    "1 2 3 10 20 30\n-1 0.5 0 255 0 1\n";

TEST(Transforms, TakeNerfstudiosPoints) {
  const ScratchFolder folder;
  const Json json = With(OneFile(), {{"ply_file_path", "./sparse_pc.ply"}});
  const Dataset without = ReadOneFile(folder, json);
  EXPECT_TRUE(without.points.empty());
  EXPECT_EQ(without.missing_files, std::vector<std::string>{"sparse_pc.ply"});

  folder.Write("sparse_pc.ply", kTwoPoints);
  const Dataset set = ReadOneFile(folder, json);
  EXPECT_TRUE(set.missing_files.empty());
  ASSERT_EQ(set.points.size(), 2u);
  EXPECT_EQ(set.points[0].position, glm::dvec3(1, 2, 3));
  EXPECT_EQ(set.points[1].color_srgb, (std::array<uint8_t, 3>{255, 0, 1}));
  EXPECT_EQ(set.points[1].track_length, 0u);

  const auto refuse = [&](const std::string& ply, const std::string& message) {
    folder.Write("sparse_pc.ply", ply);
    ExpectError<DataError>([&] { ReadOneFile(folder, json); }, {"sparse_pc.ply", message});
  };
  const auto edited = [](const std::string& from, const std::string& to) {
    std::string ply = kTwoPoints;
    return ply.replace(ply.find(from), from.size(), to);
  };
  refuse(edited("uint8 red", "uint8 grey"), "vertex property 'red' is missing");
  refuse(edited("1 2 3 10", "1 nan 3 10"), "y of vertex 0 is nan; expected");
  refuse(edited("element vertex", "element corner"), "has no vertices");
  refuse(edited("element vertex 2", "element vertex 2000000000"), "sparse_pc.ply");
  ExpectError<DataError>(
      [&] {
        ReadOneFile(folder, With(OneFile(), {{"ply_file_path", "../points.ply"}}));
      },
      {"ply_file_path is \"../points.ply\"; expected a path inside"});
}

// DL3DV-10K has no other images.
TEST(Transforms, MayBeReadWithReducedCopiesOfTheImages) {
  const ScratchFolder folder;
  folder.Write("transforms.json", With(OneFile(), {{"test_filenames", {"images/b.jpg"}}}).dump());
  for (const char* file : {"images_4/a.jpg", "images_4/b.jpg"}) folder.Write(file, "");
  ExpectError<DataError>([&] { ReadTransforms(folder.path()); },
                         {"2 of 2 images are missing", "images_4 has reduced copies", "--images"});
  const Dataset set = ReadTransforms(folder.path(), {.images = "images_4"});
  ASSERT_EQ(set.pictures.size(), 2u);
  EXPECT_EQ(set.pictures[0].name, "images/a");
  EXPECT_EQ(set.pictures[0].file, folder / "images_4/a.jpg");
  EXPECT_EQ(set.pictures[0].lens.width, 40u) << "the lens is scaled when the image is read";
  EXPECT_EQ(set.pictures[1].split, Split::kTest);
  ExpectError<DataError>([&] { ReadTransforms(folder.path(), {.images = "images_8"}); },
                         {"2 of 2 images are missing", "leave out --images"});
  ExpectError<UsageError>([&] { ReadTransforms(folder.path(), {.images = "../x"}); },
                          {"images is \"../x\""});
}

TEST(Transforms, TakeNerfstudiosSplit) {
  const ScratchFolder folder;
  const auto splits = [&](const Json& lists) {
    const Dataset set = ReadOneFile(folder, With(OneFile(), lists));
    EXPECT_TRUE(set.has_split);
    std::vector<std::pair<std::string, Split>> found;
    for (const PosedPicture& picture : set.pictures)
      found.emplace_back(picture.name, picture.split);
    return found;
  };
  using Found = std::vector<std::pair<std::string, Split>>;
  const Found a_trains = {{"images/a", Split::kTrain}, {"images/b", Split::kTest}};
  EXPECT_EQ(splits({{"train_filenames", {"images/a.jpg"}}, {"test_filenames", {"./images/b.jpg"}}}),
            a_trains);
  EXPECT_EQ(splits({{"test_filenames", {"images/b.jpg"}}}), a_trains);
  EXPECT_EQ(splits({{"val_filenames", {"images/b.jpg"}},
                    {"test_filenames", {"images/b.jpg"}},
                    {"train_filenames", {"images/a.jpg"}}}),
            a_trains);
  EXPECT_EQ(splits({{"val_filenames", {"images/a.jpg"}}}),
            (Found{{"images/a", Split::kValidation}, {"images/b", Split::kTrain}}));
  TakeWarnings();
  EXPECT_EQ(splits({{"train_filenames", {"images/b.jpg"}}}), (Found{{"images/b", Split::kTrain}}));
  const std::vector<std::string> warnings = TakeWarnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], ::testing::HasSubstr("test_filenames: 1; left out"));
}

TEST(Transforms, BringInstantNgpsBoxIntoTheInput) {
  const ScratchFolder folder;
  EXPECT_FALSE(ReadOneFile(folder, OneFile()).box_in_input);
  struct Case {
    Json fields;
    double side, scale;
    glm::dvec3 offset;
  };
  const Case cases[] = {
      {{{"aabb_scale", 1}}, 1, 0.33, glm::dvec3(0.5)},
      {{{"aabb_scale", 4}, {"scale", 0.5}, {"offset", 0.25}}, 4, 0.5, glm::dvec3(0.25)},
      {{{"aabb_scale", 2}, {"scale", 2}, {"offset", {0.1, -3, 0.5}}}, 2, 2, {0.1, -3, 0.5}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.fields.dump());
    const Dataset set = ReadOneFile(folder, With(OneFile(), c.fields));
    ASSERT_TRUE(set.box_in_input);
    // Converted back into instant-ngp's frame.
    const glm::dvec3 min = set.box_in_input->min * c.scale + c.offset;
    const glm::dvec3 max = set.box_in_input->max * c.scale + c.offset;
    EXPECT_LT(glm::length(min - (0.5 - 0.5 * c.side)), 1e-12);
    EXPECT_LT(glm::length(max - (0.5 + 0.5 * c.side)), 1e-12);
  }
  const Json aabb = {{"aabb", {{-1, -2, -3}, {1, 2, 3.5}}}, {"aabb_scale", 8}};
  const Dataset set = ReadOneFile(folder, With(OneFile(), aabb));
  EXPECT_EQ(set.box_in_input->min, glm::dvec3(-1, -2, -3));
  EXPECT_EQ(set.box_in_input->max, glm::dvec3(1, 2, 3.5));
}

TEST(Transforms, NerfSyntheticFilesMaySpecifyTheLensToo) {
  const ScratchFolder folder;
  WriteGoodSet(folder);
  const Json lens = {{"w", 40}, {"h", 30}, {"fl_x", 50}, {"k1", 0.1}, {"aabb_scale", 1}};
  folder.Write("transforms_train.json", With(Transforms({"train/r_0"}), lens).dump());
  const Dataset set = ReadNerfSynthetic(folder.path());
  EXPECT_EQ(set.pictures[0].lens.model, LensModel::kOpenCv);
  EXPECT_EQ(set.pictures[0].lens.params, (std::vector<double>{50, 50, 20, 15, 0.1, 0, 0, 0}));
  EXPECT_EQ(set.pictures[1].lens.width, 0u);
  EXPECT_TRUE(set.box_in_input);
}

TEST(Transforms, AreRefusedFieldByField) {
  struct Case {
    const char* message;
    Json fields;
  };
  const Json pose = kPose;
  const Case cases[] = {
      {"w is 0; expected 1", {{"w", 0}}},
      {"w is 40.5; expected whole pixels", {{"w", 40.5}}},
      {"h is 1000000", {{"h", 1000000}}},
      {"fl_x is 0; expected", {{"fl_x", 0}}},
      {"fl_y is -5", {{"fl_y", -5}}},
      {"cx is 1e+300", {{"cx", 1e300}}},
      {"cy is \"middle\"", {{"cy", "middle"}}},
      {"k1 is null", {{"k1", nullptr}}},
      {"k2 is 1e+300", {{"k2", 1e300}}},
      {"k1 is \"\"; expected a number", {{"k1", ""}}},
      {"k1 is \"0.1 \"; expected a number", {{"k1", "0.1 "}}},
      {"k1 is \"nan\"; expected a number", {{"k1", "nan"}}},
      {"k1 is \"1e999\"; expected a number", {{"k1", "1e999"}}},
      {"k1 is \"1e300\"; expected -1", {{"k1", "1e300"}}},
      {"fl_x is \"50\"; expected a number", {{"fl_x", "50"}}},
      {"k4 is 0.1; expected 0 for a perspective lens", {{"k4", 0.1}}},
      {"k5 is 0.1; expected 0 for a fisheye lens", {{"is_fisheye", true}, {"k5", 0.1}}},
      {"distortion_params has 4 items; expected k1, k2, k3, k4, p1, p2",
       {{"distortion_params", {0.1, 0, 0, 0}}}},
      {"distortion_params[3] is 0.1; expected 0 for a perspective lens",
       {{"distortion_params", {0, 0, 0, 0.1, 0, 0}}}},
      {"distortion_params[1] is \"x\"; expected a number",
       {{"distortion_params", {0, "x", 0, 0, 0, 0}}}},
      {"rolling_shutter is not 0", {{"rolling_shutter", {0, 0, 0.5, 0}}}},
      {"rolling_shutter is not 0", {{"rolling_shutter", 0.5}}},
      {"frames[0].rolling_shutter is not 0",
       {{"frames",
         {{{"file_path", "images/a.jpg"},
           {"transform_matrix", pose},
           {"rolling_shutter", {0, 1, 0}}}}}}},
      {"normal_mts_args means that the poses follow axes other than OpenGL's",
       {{"normal_mts_args", {"-o", "x"}}}},
      {"from_na means that the poses follow axes other than OpenGL's", {{"from_na", true}}},
      {"is_fisheye is 1; expected true or false", {{"is_fisheye", 1}}},
      {"camera_model is \"EQUIRECTANGULAR\"; expected PERSPECTIVE, ",
       {{"camera_model", "EQUIRECTANGULAR"}}},
      {"ftheta_p0 belongs to a camera model that is not supported", {{"ftheta_p0", 1.5}}},
      {"aabb_scale is 0", {{"aabb_scale", 0}}},
      {"scale is 0", {{"aabb_scale", 1}, {"scale", 0}}},
      {"offset has 2 items", {{"aabb_scale", 1}, {"offset", {1, 2}}}},
      {"aabb is not a box", {{"aabb", {{0, 0, 0}, {1, 0, 1}}}}},
      {"aabb has 3 items", {{"aabb", {{0, 0, 0}, {1, 0, 1}, {2, 2, 2}}}}},
      {"frames has no training view", {{"frames", Json::array()}}},
      {"frames has no training view", {{"test_filenames", {"images/a.jpg", "images/b.jpg"}}}},
      {"test_filenames[0] is \"images/c.jpg\", which no frame names",
       {{"test_filenames", {"images/c.jpg"}}}},
      {"val_filenames[0] is \"images/a.jpg\", which is also in train_filenames",
       {{"train_filenames", {"images/a.jpg"}}, {"val_filenames", {"images/a.jpg"}}}},
      {"test_filenames[0] is \"../a.jpg\"; expected a path inside",
       {{"test_filenames", {"../a.jpg"}}}},
      {"image \"images/a\" of transforms.json is in transforms.json already",
       {{"frames",
         {{{"file_path", "images/a.jpg"}, {"transform_matrix", pose}},
          {{"file_path", "./images/a.jpg"}, {"transform_matrix", pose}}}}}},
      {"frames[0].mask_path is \"../b.png\"; expected a path inside",
       {{"frames",
         {{{"file_path", "images/a.jpg"},
           {"transform_matrix", pose},
           {"mask_path", "../b.png"}}}}}},
  };
  const ScratchFolder folder;
  for (const Case& c : cases) {
    SCOPED_TRACE(c.message);
    ExpectError<DataError>([&] { ReadOneFile(folder, With(OneFile(), c.fields)); },
                           {folder.path().string(), c.message});
  }
}

TEST(Transforms, WithoutASizeRefuseWhatIsInPixels) {
  const ScratchFolder folder;
  const auto message = [&](const Json& fields, const char* part) {
    ExpectError<DataError>([&] { ReadOneFile(folder, With(Transforms({"images/a.jpg"}), fields)); },
                           {part});
  };
  message({{"fl_x", 50}}, "fl_x is in pixels of an image of w x h; add w and h");
  message({{"cy", 50}}, "cy is in pixels");
  message({{"k1", 0.1}}, "k1 is the lens distortion of an image of w x h; add w and h");
  message({{"distortion_params", {0, 0.1, 0, 0, 0, 0}}},
          "distortion_params[1] is the lens distortion of an image of w x h");
  message({{"is_fisheye", true}}, "frames[0] has a fisheye lens but no image size");
  message({{"w", 50}}, "h is missing");
  message({{"x_fov", 180}, {"camera_angle_x", 3.5}}, "camera_angle_x is 3.5; expected a field");
  Json degrees = Transforms({"images/a.jpg"});
  degrees.erase("camera_angle_x");
  degrees["x_fov"] = 180;
  ExpectError<DataError>([&] { ReadOneFile(folder, degrees); }, {"x_fov is 180; expected a field"});
}

TEST(Transforms, SayWhatIsMissing) {
  const ScratchFolder folder;
  ExpectError<DataError>([&] { ReadTransforms(folder.path()); }, {"transforms.json"});
}

TEST(Transforms, WithASizeNeedAFocalLengthToo) {
  const ScratchFolder folder;
  Json json = OneFile();
  json.erase("fl_x");
  json.erase("fl_y");
  ExpectError<DataError>([&] { ReadOneFile(folder, json); }, {"frames[0] has no focal length"});
}

}  // namespace
}  // namespace tetrec
