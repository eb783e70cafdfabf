// COLMAP's text models: what COLMAP writes is read, and nothing hostile is believed.
#include "colmap/text.h"

#include "core/child_process.h"
#include "core/error.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

constexpr const char* kCameras =
    "# Camera list with one line of data per camera:\n"
    "7 SIMPLE_RADIAL 64 48 100 32 24 0.01\r\n"
    "\n"
    "9 THIN_PRISM_FISHEYE 64 48 1e2 1E+2 32 24 0.1 -0.2 0 0 0 0 0 0";
constexpr const char* kImages =
    "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n"
    "1 1 0 0 0 0.5 2 3 7 my photos/a b.jpg\n"
    "10.5 20.5 5 11.5 21.5 -1\n"
    "2 0.7071067811865476 0 0 0.7071067811865476 0 0 0 9 c.jpg\n"
    "\n"
    "3 1 0 0 0 0 0 0 9 d.jpg";
constexpr const char* kPoints = "# POINT3D_ID ...\n5 1 2 3 10 20 30 0.5 1 0\n6 4 5 6 0 0 255 -1\n";

ColmapModel Read(const std::string& cameras, const std::string& images, const std::string& points) {
  const ScratchFolder folder;
  folder.Write("cameras.txt", cameras);
  folder.Write("images.txt", images);
  folder.Write("points3D.txt", points);
  return ReadColmapModel(folder.path());
}

TEST(ColmapText, EveryFieldIsReadFromItsPlace) {
  const ColmapModel model = Read(kCameras, kImages, kPoints);
  ASSERT_EQ(model.cameras.size(), 2u);
  EXPECT_EQ(model.cameras.at(7).model, LensModel::kSimpleRadial);
  EXPECT_EQ(model.cameras.at(7).width, 64u);
  EXPECT_EQ(model.cameras.at(7).params, (std::vector<double>{100, 32, 24, 0.01}));
  EXPECT_EQ(model.cameras.at(9).params.size(), 12u);
  EXPECT_EQ(model.cameras.at(9).params[5], -0.2);
  ASSERT_EQ(model.images.size(), 3u);
  const ColmapImage& first = model.images.at(1);
  EXPECT_EQ(first.name, "my photos/a b.jpg");
  EXPECT_EQ(first.cam_from_world.translation, glm::dvec3(0.5, 2, 3));
  ASSERT_EQ(first.observations.size(), 2u);
  EXPECT_EQ(first.observations[0].pixel, glm::dvec2(10.5, 20.5));
  EXPECT_EQ(first.observations[0].point, 5u);
  EXPECT_EQ(first.observations[1].point, kNoColmapPoint);
  EXPECT_TRUE(model.images.at(2).observations.empty());
  // A quarter turn about z: x goes to y.
  const glm::dvec3 turned = model.images.at(2).cam_from_world * glm::dvec3(1, 0, 0);
  EXPECT_LT(glm::distance(turned, glm::dvec3(0, 1, 0)), 1e-15);  // rounding of sqrt(0.5)
  EXPECT_EQ(model.images.at(3).name, "d.jpg");                   // its second line is not there
  EXPECT_EQ(model.points.at(5).track.size(), 1u);
  EXPECT_EQ(model.points.at(6).color_srgb[2], 255);
  EXPECT_EQ(model.points.at(6).error_px, 0);
}

TEST(ColmapText, WhatIsWrongIsNamedWithItsLine) {
  const auto cameras = [](const char* text, std::initializer_list<std::string> parts) {
    ExpectError<DataError>([&] { ParseColmapCamerasText(text, "cameras.txt"); }, parts);
  };
  cameras("# a\n1 PINHOLE 64 48 100 100 32", {"cameras.txt: line 2", "ends where", "parameter"});
  cameras("1 PINHOLE 64 48 100 100 32 24 0\n", {"line 1: continues with \"0\""});
  cameras("1 PINHOLE 64 48 100 1oo 32 24\n", {"line 1", "\"1oo\"", "expected a number"});
  cameras("1 PINHOLE 64 48 100 nan 32 24\n", {"line 1", "is nan"});
  cameras("1 PINHOLE 64 48 100 1e300 32 24\n", {"line 1", "is 1e+300"});
  cameras("1 PINHOLE 64 48 100 1e999 32 24\n", {"\"1e999\""});
  cameras("1 PINHOLE -64 48 100", {"line 1", "a width is \"-64\"", "expected an integer"});
  cameras("1 PINHOLE 0 48 100", {"line 1", "0 x 48"});
  cameras("99999999999 PINHOLE 0 48 100", {"line 1", "an id is \"99999999999\""});
  for (const char* lens : {"-0.1 1", "1.5 1", "0.5 0"}) {
    cameras(("1 EUCM 64 48 50 50 32 24 " + std::string(lens) + "\n").c_str(),
            {"line 1", "an EUCM camera has alpha", "above 0"});
  }
  cameras("1 FOV 64 48 1 1 1 1 1\n1 FOV 64 48 1 1 1 1 1\n", {"line 2", "the id 1 comes twice"});

  const auto images = [](const char* text, std::initializer_list<std::string> parts) {
    ExpectError<DataError>([&] { ParseColmapImagesText(text, "images.txt"); }, parts);
  };
  images("1 2 0 0 0 0 0 0 7 a.jpg\n\n", {"images.txt: line 1", "squared length 4"});
  images("1 1 0 0 0 0 0 0 7\n\n", {"line 1", "image name \"\""});
  images("1 1 0 0 0 0 0 0 7 ../a.jpg\n\n", {"line 1", "../a.jpg", "is not a relative path"});
  images("1 1 0 0 0 0 0 0 7 a.jpg\n1 2\n", {"line 2", "ends where an observation's point"});
  images("1 1 0 0 0 0 0 0 7 a.jpg\n1 2 -5\n", {"line 2", "point is -5"});
  // The second lines are left out: the next image is not a list of observations.
  images("1 1 0 0 0 0 0 0 7 a.jpg\n2 1 0 0 0 0 0 0 7 b.jpg\n", {"line 2", "\"b.jpg\""});

  const auto points = [](const char* text, std::initializer_list<std::string> parts) {
    ExpectError<DataError>([&] { ParseColmapPointsText(text, "points3D.txt"); }, parts);
  };
  points("5 1 2 3 10 20 300 0.5\n", {"points3D.txt: line 1", "a colour is \"300\""});
  points("5 1 2 3 10 20 30 0.5 1\n", {"line 1", "ends where a track's observation"});
  points("5 1 2 inf 10 20 30 0.5 1\n", {"line 1", "is inf"});
  points("18446744073709551616 1 2 3 0 0 0 0\n", {"line 1", "an id"});
}

TEST(ColmapText, KnowsTheLensesOfLaterVersions) {
  const auto cameras = ParseColmapCamerasText(
      "1 RAD_TAN_THIN_PRISM_FISHEYE 64 48 50 51 32 24 1 2 3 4 5 6 7 8 9 10 11 12\n"
      "2 SIMPLE_DIVISION 64 48 50 32 24 -0.1\n3 DIVISION 64 48 50 51 32 24 -0.1\n"
      "4 SIMPLE_FISHEYE 64 48 50 32 24\n5 FISHEYE 64 48 50 51 32 24\n"
      "6 EUCM 64 48 50 51 32 24 0.6 1.2\n",
      "cameras.txt");
  EXPECT_EQ(cameras.at(1).params.size(), 16u);
  EXPECT_EQ(cameras.at(1).params.back(), 12);
  for (int id = 1; id <= 6; ++id) EXPECT_EQ(cameras.at(uint32_t(id)).model, LensModel(10 + id));
}

TEST(ColmapText, ReferencesAreCheckedAsInBinaryModels) {
  ExpectError<DataError>([] { Read("", kImages, kPoints); }, {"camera 7"});
  std::string twice = kImages;
  twice[twice.find("c.jpg")] = 'd';
  ExpectError<DataError>([&] { Read(kCameras, twice.c_str(), kPoints); },
                         {"two images have the name d.jpg"});
  ExpectError<DataError>([] { Read(kCameras, kImages, ""); }, {"point 5"});
  ExpectError<DataError>([] { Read(kCameras, "", kPoints); }, {"image 1"});
}

TEST(ColmapText, AnUnknownLensMattersOnlyIfAnImageRefersToIt) {
  const std::string with_unknown = std::string(kCameras) + "\n11 NEW_LENS 64 48 1 2 3 4 5\n";
  EXPECT_EQ(Read(with_unknown, kImages, kPoints).cameras.size(), 2u);
  std::string images = kImages;
  images.replace(images.find("9 d.jpg"), 1, "11");
  ExpectError<DataError>([&] { Read(with_unknown, images, kPoints); },
                         {"image d.jpg has camera 11", "camera model \"NEW_LENS\" is unknown",
                          "OPENCV, ", "image_undistorter"});
}

TEST(ColmapText, APartOfAModelIsRefused) {
  const ScratchFolder folder;
  folder.Write("cameras.bin", std::string("x"));
  folder.Write("images.txt", std::string(kImages));
  folder.Write("points3D.txt", std::string(kPoints));
  ExpectError<DataError>([&] { ReadColmapModel(folder.path()); }, {"no complete COLMAP model"});
  // Complete text files beside a partial binary model are enough.
  folder.Write("cameras.txt", std::string(kCameras));
  EXPECT_EQ(ReadColmapModel(folder.path()).images.size(), 3u);
}

// COLMAP's own conversion is the second method.
TEST(ColmapText, ReadsTheSameAsFromColmapsBinaryFilesAndPrefersThose) {
  const std::filesystem::path colmap = FindProgram("colmap");
  if (colmap.empty()) GTEST_SKIP() << "there is no colmap in PATH";
  const ScratchFolder folder;
  folder.Write("cameras.txt", std::string(kCameras));
  folder.Write("images.txt", "1 1 0 0 0 0.5 2 3 7 a.jpg\n10.5 20.5 5 11.5 21.5 -1\n");
  folder.Write("points3D.txt", std::string("5 1 2 3 10 20 30 0.5 1 0\n"));
  const ColmapModel text = ReadColmapModel(folder.path());
  ChildOptions options;
  options.environment = {{"QT_QPA_PLATFORM", "offscreen"}};
  options.log = folder / "log.txt";
  RunChild(colmap,
           {"model_converter", "--input_path", folder.path(), "--output_path", folder.path(),
            "--output_type", "BIN"},
           options);
  ASSERT_TRUE(std::filesystem::exists(folder / "points3D.bin"));
  folder.Write("points3D.txt", std::string("not read"));
  // Files of newer versions are ignored.
  for (const char* other : {"rigs.bin", "frames.bin", "project.ini"}) {
    folder.Write(other, std::string("1234"));
  }
  const ColmapModel binary = ReadColmapModel(folder.path());
  ASSERT_EQ(binary.cameras.size(), text.cameras.size());
  for (const auto& [id, camera] : text.cameras) {
    EXPECT_EQ(binary.cameras.at(id).model, camera.model);
    EXPECT_EQ(binary.cameras.at(id).params, camera.params);
  }
  EXPECT_EQ(binary.images.at(1).name, "a.jpg");
  EXPECT_EQ(binary.images.at(1).cam_from_world.translation, glm::dvec3(0.5, 2, 3));
  EXPECT_EQ(binary.images.at(1).observations[0].pixel, text.images.at(1).observations[0].pixel);
  EXPECT_EQ(binary.points.at(5).position, text.points.at(5).position);
  EXPECT_EQ(binary.points.at(5).track[0].image, 1u);
}

}  // namespace
}  // namespace tetrec
