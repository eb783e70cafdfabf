// The photos of a folder: which are found, and which cannot be used.
#include "sfm/photos.h"

#include "core/child_process.h"
#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "expect_error.h"
#include "image/depth_map.h"
#include "image/exif_block.h"
#include "image/photo.h"
#include "scratch_folder.h"
#include "sfm/write_photo.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <span>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

class PhotosTest : public ::testing::Test {
 protected:
  PhotoFolder Find(double max_unreadable) {
    return FindPhotos(photos_, max_unreadable, folder_ / "converted");
  }
  void WritePhotos(int count) { WriteNumberedPhotos(photos_, count); }

  ScratchFolder folder_;
  const std::string photos_ = folder_ / "photos";
};

TEST_F(PhotosTest, FoldersWithoutPhotosOrWithFewerThanThreeAreRefused) {
  ExpectError<DataError>([&] { Find(0.25); }, {"is not a folder"});
  fs::create_directories(photos_);
  folder_.Write("photos/readme.txt", "no photo");
  folder_.Write("photos/.hidden.jpg", "no photo");
  ExpectError<DataError>([&] { Find(0.25); }, {"contains no photos"});
  WritePhotos(1);
  ExpectError<DataError>([&] { Find(0.25); }, {"only 1 photo (", "photo 00.png"});
  WritePhotos(2);
  ExpectError<DataError>([&] { Find(0.25); },
                         {"only 2 photos (photo 00.png, photo 01.png)", "at least 3"});
  WritePhotos(3);
  folder_.Write("photos/photo 02.png", "damaged");
  ExpectError<DataError>([&] { Find(0.5); }, {"only 2 of 3 photos can be read", "at least 3"});
  fs::copy_file(photos_ + "/photo 01.png", photos_ + "/photo 03.png");
  ExpectError<DataError>([&] { Find(0.5); },
                         {"only 2 of 4 photos can be read and are not copies", "at least 3"});
}

TEST_F(PhotosTest, PhotosInLinkedFoldersAreFound) {
  WriteNumberedPhotos(folder_ / "elsewhere", 3);
  WritePhoto(fs::path(photos_) / "photo 00.png", 200);
  fs::create_directory_symlink("../elsewhere", fs::path(photos_) / "day2");
  const PhotoFolder found = Find(0.25);
  ASSERT_EQ(found.photos.size(), 4u);
  EXPECT_EQ(found.photos[0].name, "day2/photo 00.png");
}

TEST_F(PhotosTest, ReducedCopiesBesideTheirPhotosAreLeftOut) {
  WriteNumberedPhotos(folder_ / "photos/images", 3);
  WritePhoto(fs::path(photos_) / "images_4/photo 00.png", 200);
  WritePhoto(fs::path(photos_) / "images_5/photo 00.png", 100);
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(Find(0.25).photos.size(), 4u);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              ::testing::HasSubstr("reduced copies of the photos in images are left out: "
                                   "images_4\n"));
  fs::rename(fs::path(photos_) / "images", fs::path(photos_) / "others");
  EXPECT_EQ(Find(0.25).photos.size(), 5u) << "they may be the photos themselves";
  fs::create_directory(fs::path(photos_) / "images");
  EXPECT_EQ(Find(0.25).photos.size(), 5u) << "images is empty";
}

TEST_F(PhotosTest, KnownCamerasThatAreNotReadAreNamed) {
  for (const char* cameras :
       {"cameras_sphere.npz", "cameras.npz", "poses_bounds.npy", "pose", "cams"}) {
    const ScratchFolder folder;
    WriteNumberedPhotos(folder / "image", 3);
    const std::string name = cameras;
    if (name == "pose") folder.Write("intrinsics.txt", "");
    folder.Write(name == "pose" ? "pose/0.txt" : name == "cams" ? "cams/0_cam.txt" : name, "");
    TakeWarnings();
    FindPhotos(folder.path(), 0.25, folder_ / "converted");
    EXPECT_THAT(TakeWarnings(), ::testing::ElementsAre(::testing::AllOf(
                                    ::testing::HasSubstr("cameras in " + name + " are of a format"),
                                    ::testing::HasSubstr("give " + (folder / "image").string()))));
  }
  WritePhotos(3);
  folder_.Write("photos/cams/notes.txt", "");
  Find(0.25);
  EXPECT_TRUE(TakeWarnings().empty());
}

TEST_F(PhotosTest, ImagesOfOtherKindsAreNamed) {
  WritePhotos(1);
  folder_.Write("photos/b.WebP", "of a phone");
  folder_.Write("photos/notes.txt", "no photo");
  TakeWarnings();
  ExpectError<DataError>([&] { Find(0.25); }, {"only 1 photo"});
  EXPECT_THAT(TakeWarnings(), ::testing::ElementsAre(::testing::AllOf(
                                  ::testing::HasSubstr("HEIC are left out: 1: b.WebP; convert"),
                                  ::testing::Not(::testing::HasSubstr("notes")))));
}

TEST_F(PhotosTest, NamesThatCannotBeStoredAreRefusedBeforeAnythingIsRead) {
  WritePhotos(3);
  folder_.Write(
      "photos/Gr\xf6\xdf"
      "e.jpg",
      "not read");
  folder_.Write("photos/a\nb.png", "not read");
  ExpectError<DataError>([&] { Find(0.25); }, {": 2: ", "rename them"});
}

TEST_F(PhotosTest, LinksThatLeadNowhereOrToThemselvesAreNamed) {
  WritePhotos(3);
  fs::create_symlink("nowhere", fs::path(photos_) / "lost.jpg");
  fs::create_symlink("loop.jpg", fs::path(photos_) / "loop.jpg");
  ExpectError<DataError>([&] { Find(0.25); }, {"2 of 5", "lost.jpg", "loop.jpg"});
}

TEST_F(PhotosTest, AllPhotosThatCannotBeReadAreNamedAtOnce) {
  WritePhotos(3);
  folder_.Write("photos/letter.jpg", "this is a text");
  folder_.Write("photos/empty.png", "");
  const std::vector<uint8_t> whole = ReadBytes(fs::path(photos_) / "photo 00.png");
  folder_.Write("photos/cut.png", std::span(whole).first(whole.size() / 2));
  ExpectError<DataError>([&] { Find(0.25); }, {"3 of 6", "letter.jpg", "empty.png", "cut.png"});
}

TEST_F(PhotosTest, FewUnreadablePhotosAreLeftOutWithOneWarning) {
  WritePhotos(3);
  folder_.Write("photos/letter.jpg", "this is a text");
  TakeWarnings();
  const PhotoFolder found = Find(0.25);
  ASSERT_EQ(found.photos.size(), 3u);
  EXPECT_EQ(found.photos[0].name, "photo 00.png");
  EXPECT_GT(found.photos[2].width, 0);
  EXPECT_EQ(found.unreadable, std::vector<std::string>{"letter.jpg"});
  EXPECT_THAT(TakeWarnings(),
              ::testing::ElementsAre(::testing::AllOf(
                  ::testing::HasSubstr("1 of 4 photos cannot be read and are left out"),
                  ::testing::HasSubstr("letter.jpg: not a photo that can be read; expected JPEG, "
                                       "PNG, TIFF or HEIC"))));
  ExpectError<DataError>([&] { Find(0.24); }, {"1 of 4", "max-unreadable is 0.24"});
}

TEST_F(PhotosTest, CopiesAreLeftOutWithOneWarning) {
  WritePhotos(3);
  fs::copy_file(photos_ + "/photo 01.png", photos_ + "/photo 01 (copy).png");
  fs::copy_file(photos_ + "/photo 01.png", photos_ + "/z.png");
  TakeWarnings();
  const PhotoFolder found = Find(0.25);
  ASSERT_EQ(found.photos.size(), 3u);
  EXPECT_EQ(found.photos[1].name, "photo 01 (copy).png") << "the first by name stays";
  EXPECT_TRUE(found.unreadable.empty());
  EXPECT_THAT(TakeWarnings(),
              ::testing::ElementsAre(::testing::HasSubstr(
                  "copies of others are left out: 2: photo 01.png (of photo 01 (copy).png), "
                  "z.png (of photo 01 (copy).png)")));
}

TEST_F(PhotosTest, TheRemedyOffersOnlyWhatTheStageReads) {
  WritePhotos(3);
  WriteDepthMap(fs::path(photos_) / "depth.exr", MakeDepthMap(8, 8));
  fs::rename(fs::path(photos_) / "depth.exr", fs::path(photos_) / "depth.jpg");
  try {
    Find(0);
    FAIL() << "an EXR is taken";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("expected JPEG, PNG, TIFF or HEIC"));
    EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("EXR")));
  }
}

TEST_F(PhotosTest, HeicBecomesJpegWhateverItsNameIs) {
  const fs::path encoder = FindProgram("heif-enc");
  if (encoder.empty()) GTEST_SKIP() << "heif-enc is not installed (scripts/setup.sh)";
  WritePhotos(2);
  WritePhoto(folder_ / "a.jpg", 90, 80);
  const auto encode = [&](const std::string& from, const std::string& to) {
    return RunChild(encoder, {folder_ / from, "-o", folder_ / to}, {}).exit_code;
  };
  ASSERT_EQ(encode("a.jpg", "photos/a.heic"), 0);
  // Its property of pixels becomes a turn by 90 degrees.
  std::vector<uint8_t> turned = ReadBytes(folder_ / "photos/a.heic");
  const std::string property = "pixi", turn = "irot";
  const auto place = std::search(turned.begin(), turned.end(), property.begin(), property.end());
  ASSERT_NE(place, turned.end());
  std::copy(turn.begin(), turn.end(), place);
  place[4] = 1;
  folder_.Write("photos/b.jpg", turned);
  WritePhoto(fs::path(photos_) / "c.jpg", 70, 72);
  fs::rename(fs::path(photos_) / "c.jpg", fs::path(photos_) / "c.HEIC");  // a JPEG file
  const std::vector<Photo> photos = Find(0).photos;
  ASSERT_EQ(photos.size(), 5u);
  EXPECT_EQ(photos[0].name, "a.heic");
  EXPECT_EQ(photos[0].width, 80);
  EXPECT_EQ(photos[0].for_colmap.extension(), ".jpg");
  EXPECT_EQ(photos[0].file, photos[0].for_colmap);
  EXPECT_NEAR(ReadImage(photos[0].file).At(5, 5)[1], 90, 2);
  EXPECT_EQ(photos[1].name, "b.jpg");
  EXPECT_EQ(photos[1].width, 48);
  EXPECT_EQ(photos[1].height, 80);
  EXPECT_EQ(photos[2].width, 72);
  EXPECT_EQ(photos[2].file, fs::path(photos_) / "c.HEIC");
  // What is converted stays.
  const auto time = fs::last_write_time(photos[0].file);
  EXPECT_EQ(Find(0).photos[0].sha256, photos[0].sha256);
  EXPECT_EQ(fs::last_write_time(photos[0].file), time);
}

TEST_F(PhotosTest, ADamagedHeicIsLeftOutLikeOtherDamagedPhotos) {
  if (FindProgram("heif-convert").empty())
    GTEST_SKIP() << "heif-convert is not installed (scripts/setup.sh)";
  WritePhotos(3);
  std::string heic(412, 'x');
  heic.replace(0, 4, "\0\0\0\x18", 4).replace(4, 8, "ftypheic");
  folder_.Write("photos/a.heic", heic);
  TakeWarnings();
  EXPECT_EQ(Find(0.25).photos.size(), 3u);
  EXPECT_THAT(TakeWarnings(), ::testing::ElementsAre(::testing::HasSubstr(
                                  "a.heic: cannot be read as HEIC (Could not read HEIF")));
}

TEST_F(PhotosTest, AnOrientationSpecifiesHowAPhotoMustBeTurned) {
  WritePhotos(2);
  WritePhoto(fs::path(photos_) / "a.jpg", 90, 80);
  const std::vector<uint8_t> jpeg = ReadBytes(fs::path(photos_) / "a.jpg");
  folder_.Write("photos/a.jpg", WithApp1(jpeg, ExifOfOrientation(6)));
  const std::vector<Photo> photos = Find(0).photos;
  EXPECT_EQ(photos[0].width, 80) << "as it is stored";
  EXPECT_EQ(photos[0].quarter_turns, 1);
  EXPECT_EQ(photos[1].quarter_turns, 0);
}

TEST_F(PhotosTest, ColmapGetsAJpegInsteadOfATiff) {
  WritePhotos(2);
  cv::Mat pixels(48, 64, CV_16UC3, cv::Scalar(2570, 5140, 7710));
  ASSERT_TRUE(cv::imwrite((fs::path(photos_) / "a.tif").string(), pixels));
  const std::vector<Photo> photos = Find(0).photos;
  EXPECT_EQ(photos[0].file, fs::path(photos_) / "a.tif");
  EXPECT_EQ(ReadPhoto(photos[0].file).At(3, 3)[0], 30);
  EXPECT_EQ(photos[0].for_colmap.extension(), ".jpg");
  const Image for_colmap = ReadImage(photos[0].for_colmap);
  EXPECT_EQ(for_colmap.width, 64);
  EXPECT_NEAR(for_colmap.At(3, 3)[0], 30, 2);
  EXPECT_EQ(photos[0].sha256, Sha256OfFile(photos[0].for_colmap));
  EXPECT_EQ(photos[1].for_colmap, fs::path(photos_) / "photo 00.png");
}

TEST_F(PhotosTest, ColmapGetsAJpegInsteadOfAColouredPngOfSixteenBits) {
  const auto write = [&](const char* name, int type, double blue) {
    const cv::Scalar color(blue, 5140, 7710, 65535);
    ASSERT_TRUE(cv::imwrite((fs::path(photos_) / name).string(), cv::Mat(48, 64, type, color)));
  };
  fs::create_directories(photos_);
  write("a.png", CV_16UC3, 2570);
  write("b.png", CV_16UC4, 5140);
  write("c.png", CV_16UC1, 5140);
  const std::vector<Photo> photos = Find(0).photos;
  ASSERT_EQ(photos.size(), 3u);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(photos[i].for_colmap.extension(), ".jpg");
    EXPECT_NEAR(ReadImage(photos[i].for_colmap).At(3, 3)[0], 30, 2);
    EXPECT_EQ(photos[i].file, fs::path(photos_) / photos[i].name) << "the pixels are its own";
  }
  EXPECT_EQ(photos[2].for_colmap, photos[2].file) << "COLMAP reads grey";
}

TEST_F(PhotosTest, PhotosAreFoundInFoldersAndSortedByName) {
  WritePhoto(fs::path(photos_) / "b/2.png", 10);
  WritePhoto(fs::path(photos_) / "b/1.PNG", 20);
  WritePhoto(fs::path(photos_) / "a.jpg", 30, 32);
  const std::vector<Photo> photos = Find(0).photos;
  ASSERT_EQ(photos.size(), 3u);
  EXPECT_EQ(photos[0].name, "a.jpg");
  EXPECT_EQ(photos[0].width, 32);
  EXPECT_EQ(photos[1].name, "b/1.PNG");
  EXPECT_EQ(photos[2].name, "b/2.png");
}

}  // namespace
}  // namespace tetrec
