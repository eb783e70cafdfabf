// COLMAP data sets: how the model, the images and the masks are found.
#include "import/colmap_dataset.h"

#include "core/error.h"
#include "core/log.h"
#include "expect_error.h"
#include "image/image.h"
#include "import/import.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

// Cameras on a ring around the origin, level, and points on a ball there; no observations.
void WriteModel(const ScratchFolder& folder, const std::string& place,
                const std::vector<std::string>& names, const std::string& camera) {
  std::string images, points;
  for (size_t i = 0; i < names.size(); ++i) {
    const double half = 3.14159 * double(i) / double(names.size());
    images +=
        fmt::format("{} {} 0 {} 0 0 0 4 1 {}\n\n", i + 1, std::cos(half), std::sin(half), names[i]);
  }
  for (int i = 0; i < 200; ++i) {
    points += fmt::format("{} {} {} {} 9 9 9 0.5 1 0 2 0 3 0\n", i + 1, 0.5 * std::sin(i),
                          0.5 * std::cos(0.7 * i), 0.5 * std::sin(1.3 * i));
  }
  // Tracks refer to an observation.
  for (size_t at = 0; (at = images.find("\n\n", at)) != std::string::npos; at += 2) {
    images.replace(at, 2, "\n1 1 -1\n");
  }
  folder.Write(place + "/cameras.txt", camera);
  folder.Write(place + "/images.txt", images);
  folder.Write(place + "/points3D.txt", points);
}

void WritePictures(const ScratchFolder& folder, const std::string& place,
                   const std::vector<std::string>& names, int width, int height) {
  for (const std::string& name : names) {
    const std::filesystem::path path = folder / (place + "/" + name);
    std::filesystem::create_directories(path.parent_path());
    WriteImage(path, MakeImage(width, height, 3));
  }
}

const std::vector<std::string> kNames = {"a.jpg", "sub folder/b.jpg", "c.png"};
constexpr const char* kPinhole = "1 PINHOLE 64 48 60 60 32 24\n";

TEST(ColmapDataset, FindsTheModelItsImagesAndMasksOfBothNamings) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images", kNames, 64, 48);
  WritePictures(folder, "masks", {"a.jpg.png", "sub folder/b.png", "c.png"}, 64, 48);
  const Dataset set = ReadColmapDataset(folder.path());
  ASSERT_EQ(set.pictures.size(), 3u);
  EXPECT_EQ(set.points.size(), 200u);
  EXPECT_EQ(set.pictures[0].name, "a.jpg");
  EXPECT_EQ(set.pictures[0].mask, folder / "masks/a.jpg.png");
  EXPECT_EQ(set.pictures[1].name, "c.png");
  EXPECT_EQ(set.pictures[1].mask, folder / "masks/c.png");
  EXPECT_EQ(set.pictures[2].file, folder / "images/sub folder/b.jpg");
  EXPECT_EQ(set.pictures[2].mask, folder / "masks/sub folder/b.png");
  EXPECT_TRUE(set.remarks.empty());
  EXPECT_EQ(ReadDataset(folder.path(), DatasetFormat::kColmap).pictures[0].image, "images/a.png");
}

TEST(ColmapDataset, PointsThatAreNotNeededAreLeftOutWithARemark) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images", kNames, 64, 48);
  const Dataset set = ReadColmapDataset(folder.path(), {.points = false});
  EXPECT_TRUE(set.points.empty());
  EXPECT_THAT(set.remarks, testing::ElementsAre(testing::HasSubstr("points of the data set")));
}

TEST(ColmapDataset, ATransformsJsonIsPreferredOnlyIfItHasMoreThanCameras) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  const auto recognise = [&](const std::string& fields, const std::string& of_frame) {
    folder.Write("transforms.json",
                 fmt::format(R"({{"frames": [{{"file_path": "a.jpg"{}}}]{}}})", of_frame, fields));
    return RecogniseDataset(folder.path());
  };
  EXPECT_EQ(recognise("", ""), DatasetFormat::kTransforms) << "the model has no images";
  WritePictures(folder, "images", kNames, 64, 48);
  const std::string points = R"(, "ply_file_path": "points.ply")";
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(recognise("", ""), DatasetFormat::kColmap);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              testing::HasSubstr("read as colmap, since its transforms.json has no points, masks "
                                 "or split; it is transforms as well"));
  EXPECT_EQ(recognise(points, ""), DatasetFormat::kColmap) << "the file does not exist";
  folder.Write("points.ply", "");
  EXPECT_EQ(recognise(points, ""), DatasetFormat::kTransforms);
  EXPECT_EQ(recognise(R"(, "test_filenames": [])", ""), DatasetFormat::kTransforms);
  EXPECT_EQ(recognise("", R"(, "mask_path": "a.png")"), DatasetFormat::kTransforms);
  std::filesystem::remove(folder / "sparse/0/points3D.txt");
  EXPECT_EQ(recognise("", ""), DatasetFormat::kTransforms) << "the model lacks a part";
  folder.Write("transforms_train.json", "{}");
  EXPECT_EQ(recognise("", ""), DatasetFormat::kNerfSynthetic);
}

TEST(ColmapDataset, ModelsFromWhichPointsWereRemovedAreRead) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images", kNames, 64, 48);
  folder.Write("sparse/0/points3D.txt", "1 0 0 0 9 9 9 0.5 1 0 2 0 7 0\n");
  TakeWarnings();
  const Dataset set = ReadColmapDataset(folder.path());
  ASSERT_EQ(set.points.size(), 1u);
  EXPECT_EQ(set.points[0].track_length, 2u);
  EXPECT_THAT(TakeWarnings(), testing::ElementsAre(testing::HasSubstr("removed: 1; left out")));
}

TEST(ColmapDataset, HowTheFolderIsWrittenDoesNotMatter) {
  const ScratchFolder folder;
  WriteModel(folder, "set/sparse/0", kNames, kPinhole);
  WritePictures(folder, "set/images_4", kNames, 16, 12);
  WritePictures(folder, "set/masks", {"a.jpg.png", "sub folder/b.png", "c.png"}, 16, 12);
  for (const char* set : {"set", "set/", "set/.", "set/../set"}) {
    for (const char* images : {"images_4", "images_4/"}) {
      const Dataset read =
          ReadColmapDataset(folder.path().string() + "/" + set, {.images = images});
      EXPECT_EQ(read.pictures.size(), 3u) << set;
      EXPECT_FALSE(read.pictures[0].mask.empty()) << set << " " << images;
    }
  }
  const Dataset model_alone =
      ReadColmapDataset(folder / "set/sparse/0/../..", {.images = "images_4"});
  EXPECT_EQ(model_alone.pictures.size(), 3u);
}

TEST(ColmapDataset, ImagesThatTheModelLacksAreCounted) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images", kNames, 64, 48);
  WritePictures(folder, "images", {"d.JPG", "sub folder/e.png"}, 64, 48);
  folder.Write("images/notes.txt", "");
  EXPECT_THAT(ReadColmapDataset(folder.path()).remarks,
              testing::ElementsAre(testing::HasSubstr("2 images are not in the model")));
}

TEST(ColmapDataset, TheFirstOfSeveralModelsIsReadWithARemark) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WriteModel(folder, "sparse/1", kNames, kPinhole);
  WritePictures(folder, "images", kNames, 64, 48);
  EXPECT_THAT(ReadColmapDataset(folder.path()).remarks,
              testing::ElementsAre(testing::HasSubstr("several models")));
}

TEST(ColmapDataset, AFocalLengthThatIsNotPositiveIsRefusedAtItsLine) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, "1 PINHOLE 64 48 60 -60 32 24\n");
  WritePictures(folder, "images", kNames, 64, 48);
  ExpectError<DataError>([&] { ReadColmapDataset(folder.path()); },
                         {"cameras.txt", "focal length -60"});
}

TEST(ColmapDataset, MasksOfNoImageAreIgnored) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images", kNames, 64, 48);
  WritePictures(folder, "masks", {"other.png"}, 64, 48);
  const Dataset set = ReadColmapDataset(folder.path());
  ASSERT_EQ(set.remarks.size(), 1u);
  EXPECT_THAT(set.remarks[0], testing::HasSubstr("no mask of any image"));
  EXPECT_TRUE(set.pictures[0].mask.empty());
}

// 2D Gaussian splatting's copies of DTU have such a folder.
TEST(ColmapDataset, AFolderOfMasksWithAnotherNameIsIgnoredWithARemark) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images", kNames, 64, 48);
  WritePictures(folder, "mask", {"000.png"}, 64, 48);
  EXPECT_THAT(ReadColmapDataset(folder.path()).remarks,
              testing::ElementsAre(testing::AllOf(
                  testing::HasSubstr("mask is ignored"),
                  testing::HasSubstr("read from masks, under names like a.jpg.png"))));
}

TEST(ColmapDataset, MissingImagesAreCountedAndNamed) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse", kNames, kPinhole);
  WritePictures(folder, "images", {"c.png"}, 64, 48);
  ExpectError<DataError>(
      [&] { ReadColmapDataset(folder.path()); },
      {"2 of 3 images are missing", "a.jpg, sub folder/b.jpg", "skip missing", "tetrec-sfm"});
}

TEST(ColmapDataset, MissingImagesAreLeftOutOnRequest) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse", kNames, kPinhole);
  WritePictures(folder, "images", {"c.png"}, 64, 48);
  WritePictures(folder, "masks", {"c.png"}, 64, 48);
  const Dataset set =
      ReadDataset(folder.path(), DatasetFormat::kAuto, {.missing = MissingPictures::kSkip});
  ASSERT_EQ(set.pictures.size(), 1u);
  EXPECT_EQ(set.pictures[0].name, "c.png");
  EXPECT_EQ(set.pictures[0].mask, folder / "masks/c.png");
  EXPECT_EQ(set.skipped, (std::vector<std::string>{"a.jpg", "sub folder/b.jpg"}));
  EXPECT_EQ(set.points.size(), 200u);
  std::filesystem::remove(folder / "images/c.png");
  ExpectError<DataError>(
      [&] {
        ReadDataset(folder.path(), DatasetFormat::kAuto, {.missing = MissingPictures::kSkip});
      },
      {"3 of 3 images are missing"});
}

TEST(ColmapDataset, ALensThatFoldsOverIsNamedWithItsImage) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse", kNames, "1 SIMPLE_RADIAL 64 48 60 32 24 -30\n");
  WritePictures(folder, "images", kNames, 64, 48);
  try {
    ImportDataset(folder.path(), folder / "scene", {});
    ADD_FAILURE() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr((folder / "images").string()));
    EXPECT_THAT(error.what(),
                testing::HasSubstr(" (lens SIMPLE_RADIAL): the lens distortion cannot be undone"));
    EXPECT_THAT(error.what(), testing::Not(testing::HasSubstr("--camera-model")));
  }
}

TEST(ColmapDataset, ErrorsSayWhyAFolderIsNotADataSet) {
  const ScratchFolder folder;
  ExpectError<DataError>([&] { RecogniseDataset(folder / "none"); },
                         {"none: no such folder; expected a data set"});
  ExpectError<DataError>([&] { RecogniseDataset(folder.path()); },
                         {"is not a data set with known cameras", "tetrec-sfm"});
  ExpectError<DataError>([&] { ReadColmapDataset(folder.path()); }, {"no COLMAP model"});
  WriteModel(folder, "sparse", {}, kPinhole);
  folder.Write("sparse/points3D.txt", std::string());
  ExpectError<DataError>([&] { ReadColmapDataset(folder.path()); }, {"the model has no images"});
  WriteModel(folder, "sparse", kNames, kPinhole);
  ExpectError<DataError>([&] { ReadColmapDataset(folder.path()); },
                         {"no folder images", "the folder of images"});
  ExpectError<UsageError>([&] { ReadColmapDataset(folder.path(), {.images = "../x"}); },
                          {"images is \"../x\""});
  ExpectError<UsageError>(
      [&] { ReadDataset(folder.path(), DatasetFormat::kNerfSynthetic, {.images = "images_4"}); },
      {"images is \"images_4\"", "read as nerf-synthetic"});
}

// The model is of 64 x 48 pixels, the images of 33 x 25, rounded up as by some programs.
TEST(ColmapDataset, TheLensIsScaledToSmallerCopiesOfTheImages) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images_2", kNames, 33, 25);
  ImportOptions options;
  options.images = "images_2";
  options.holdout = 0;
  const ImportedScene imported = ImportDataset(folder.path(), folder / "scene", options);
  EXPECT_EQ(imported.lenses_scaled, 3u);
  const Camera& camera = imported.scene.cameras.at(0);
  EXPECT_EQ(camera.width, 33);
  EXPECT_NEAR(camera.fx, 60.0 * 33 / 64, 1e-12);
  EXPECT_NEAR(camera.fy, 60.0 * 25 / 48, 1e-12);
  EXPECT_TRUE(std::filesystem::exists(folder / "scene/images/sub folder/b.png"));

  WritePictures(folder, "images_2", kNames, 33, 27);
  ExpectError<DataError>([&] { ImportDataset(folder.path(), folder / "scene", options); },
                         {"33 x 27", "64 x 48", "another aspect ratio"});
}

// As gsplat names its copies.
TEST(ColmapDataset, ReducedCopiesWithOtherExtensionsAreFound) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images_4_png", {"a.png", "sub folder/b.PNG", "c.png"}, 16, 12);
  ::testing::internal::CaptureStderr();
  const Dataset set = ReadColmapDataset(folder.path(), {.images = "images_4_png"});
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              testing::HasSubstr("images with other names, found by their stems: 2: a.jpg is "
                                 "a.png, sub folder/b.jpg is sub folder/b.PNG"));
  EXPECT_EQ(set.pictures[0].name, "a.jpg");
  EXPECT_EQ(set.pictures[0].file, folder / "images_4_png/a.png");
  EXPECT_TRUE(set.remarks.empty());
}

// As LLFF names its copies; the model lacks d.jpg.
TEST(ColmapDataset, ReducedCopiesWithOtherNamesArePairedInOrder) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images", kNames, 64, 48);
  WritePictures(folder, "images", {"d.jpg"}, 64, 48);
  WritePictures(folder, "images_8", {"image000.png", "image001.png", "image002.png"}, 8, 6);
  const auto read = [&] { return ReadColmapDataset(folder.path(), {.images = "images_8"}); };
  ExpectError<DataError>(read, {"images_8: 3 of 3 images are missing, also with other extensions",
                                "leave out --images to read images"});
  WritePictures(folder, "images_8", {"image003.png"}, 8, 6);
  ::testing::internal::CaptureStderr();
  const Dataset set = read();
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              testing::HasSubstr("images_8: images with other names, found by the order of those "
                                 "in images: 3: a.jpg is image000.png"));
  EXPECT_EQ(set.pictures[1].name, "c.png");
  EXPECT_EQ(set.pictures[1].file, folder / "images_8/image001.png");
  EXPECT_EQ(set.pictures[2].file, folder / "images_8/image003.png");
  EXPECT_THAT(set.remarks, testing::ElementsAre(testing::HasSubstr("1 images are not in the")));
  // By their names, 10 would come before 9.
  std::filesystem::rename(folder / "images_8/image003.png", folder / "images_8/image03.png");
  ExpectError<DataError>(read, {"images_8: 3 of 3 images are missing"});
}

TEST(ColmapDataset, ImagesMayBeInTheDataSetsOwnFolder) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, ".", kNames, 64, 48);
  WritePictures(folder, "depths", {"a.png"}, 64, 48);
  const Dataset set = ReadColmapDataset(folder.path(), {.images = "."});
  EXPECT_EQ(set.pictures[0].file, folder / "a.jpg");
  EXPECT_THAT(set.remarks, testing::IsEmpty());
}

TEST(ColmapDataset, ReducedCopiesAreAdvisedWhereTheImagesAreMissing) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, kPinhole);
  WritePictures(folder, "images_4", kNames, 16, 12);
  ExpectError<DataError>([&] { ReadColmapDataset(folder.path()); },
                         {"no folder images", "--images images_4"});
}

// The image shows 183 degrees in 64 pixels.
TEST(ColmapDataset, FisheyeImagesTooWideForAPlaneAreCroppedAndCounted) {
  const ScratchFolder folder;
  WriteModel(folder, "sparse/0", kNames, "1 SIMPLE_RADIAL_FISHEYE 64 48 20 32 24 0\n");
  WritePictures(folder, "images", kNames, 64, 48);
  const ImportedScene imported = ImportDataset(folder.path(), folder / "scene", {});
  EXPECT_EQ(imported.cut_to_plane, 3u);
  EXPECT_EQ(imported.lenses_scaled, 0u);
  EXPECT_EQ(imported.scene.cameras.size(), 1u);
  const Image picture = ReadImage(folder / "scene/images/a.png");
  EXPECT_EQ(picture.width, imported.scene.cameras[0].width);
  // They are cropped at 60 degrees to each side.
  EXPECT_NEAR(imported.scene.cameras[0].CamFromImage({0, 0}).x, -std::sqrt(3.0), 1e-9);
}

}  // namespace
}  // namespace tetrec
