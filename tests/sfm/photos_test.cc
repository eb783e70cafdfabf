// The photos of a folder: which are found, and which cannot be used.
#include "sfm/photos.h"

#include "core/error.h"
#include "core/file.h"
#include "core/log.h"
#include "expect_error.h"
#include "image/depth_map.h"
#include "scratch_folder.h"
#include "sfm/write_photo.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <span>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

class PhotosTest : public ::testing::Test {
 protected:
  void WritePhotos(int count) { WriteNumberedPhotos(photos_, count); }

  ScratchFolder folder_;
  const std::string photos_ = folder_ / "photos";
};

TEST_F(PhotosTest, FoldersWithoutPhotosOrWithOneAreRefused) {
  ExpectError<DataError>([&] { FindPhotos(photos_, 0.25); }, {"is not a folder"});
  fs::create_directories(photos_);
  folder_.Write("photos/readme.txt", "no photo");
  folder_.Write("photos/.hidden.jpg", "no photo");
  ExpectError<DataError>([&] { FindPhotos(photos_, 0.25); }, {"contains no photos"});
  WritePhotos(1);
  ExpectError<DataError>([&] { FindPhotos(photos_, 0.25); }, {"only one photo", "photo 00.png"});
}

TEST_F(PhotosTest, ImagesOfOtherKindsAreNamed) {
  WritePhotos(1);
  folder_.Write("photos/b.HEIC", "of a phone");
  folder_.Write("photos/notes.txt", "no photo");
  TakeWarnings();
  ExpectError<DataError>([&] { FindPhotos(photos_, 0.25); }, {"only one photo"});
  EXPECT_THAT(TakeWarnings(),
              ::testing::ElementsAre(::testing::AllOf(
                  ::testing::HasSubstr("neither JPEG nor PNG are left out: 1: b.HEIC; convert"),
                  ::testing::Not(::testing::HasSubstr("notes")))));
}

TEST_F(PhotosTest, NamesThatCannotBeStoredAreRefusedBeforeAnythingIsRead) {
  WritePhotos(3);
  folder_.Write(
      "photos/Gr\xf6\xdf"
      "e.jpg",
      "not read");
  folder_.Write("photos/a\nb.png", "not read");
  ExpectError<DataError>([&] { FindPhotos(photos_, 0.25); }, {": 2: ", "rename them"});
}

TEST_F(PhotosTest, LinksThatLeadNowhereOrToThemselvesAreNamed) {
  WritePhotos(3);
  fs::create_symlink("nowhere", fs::path(photos_) / "lost.jpg");
  fs::create_symlink("loop.jpg", fs::path(photos_) / "loop.jpg");
  ExpectError<DataError>([&] { FindPhotos(photos_, 0.25); }, {"2 of 5", "lost.jpg", "loop.jpg"});
}

TEST_F(PhotosTest, AllPhotosThatCannotBeReadAreNamedAtOnce) {
  WritePhotos(3);
  folder_.Write("photos/letter.jpg", "this is a text");
  folder_.Write("photos/empty.png", "");
  const std::vector<uint8_t> whole = ReadBytes(fs::path(photos_) / "photo 00.png");
  folder_.Write("photos/cut.png", std::span(whole).first(whole.size() / 2));
  ExpectError<DataError>([&] { FindPhotos(photos_, 0.25); },
                         {"3 of 6", "letter.jpg", "empty.png", "cut.png"});
}

TEST_F(PhotosTest, FewUnreadablePhotosAreLeftOutWithOneWarning) {
  WritePhotos(3);
  folder_.Write("photos/letter.jpg", "this is a text");
  TakeWarnings();
  const PhotoFolder found = FindPhotos(photos_, 0.25);
  ASSERT_EQ(found.photos.size(), 3u);
  EXPECT_EQ(found.photos[0].name, "photo 00.png");
  EXPECT_GT(found.photos[2].width, 0);
  EXPECT_EQ(found.unreadable, std::vector<std::string>{"letter.jpg"});
  EXPECT_THAT(TakeWarnings(),
              ::testing::ElementsAre(::testing::AllOf(
                  ::testing::HasSubstr("1 of 4 photos cannot be read and are left out"),
                  ::testing::HasSubstr("letter.jpg: not a photo that can be read; expected JPEG "
                                       "or PNG"))));
  ExpectError<DataError>([&] { FindPhotos(photos_, 0.24); }, {"1 of 4", "max-unreadable is 0.24"});
}

TEST_F(PhotosTest, TheRemedyOffersOnlyWhatTheStageReads) {
  WritePhotos(3);
  WriteDepthMap(fs::path(photos_) / "depth.exr", MakeDepthMap(8, 8));
  fs::rename(fs::path(photos_) / "depth.exr", fs::path(photos_) / "depth.jpg");
  try {
    FindPhotos(photos_, 0);
    FAIL() << "an EXR is taken";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("expected JPEG or PNG"));
    EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("EXR")));
  }
}

TEST_F(PhotosTest, PhotosAreFoundInFoldersAndSortedByName) {
  WritePhoto(fs::path(photos_) / "b/2.png", 10);
  WritePhoto(fs::path(photos_) / "b/1.PNG", 20);
  WritePhoto(fs::path(photos_) / "a.jpg", 30, 32);
  const std::vector<Photo> photos = FindPhotos(photos_, 0).photos;
  ASSERT_EQ(photos.size(), 3u);
  EXPECT_EQ(photos[0].name, "a.jpg");
  EXPECT_EQ(photos[0].width, 32);
  EXPECT_EQ(photos[1].name, "b/1.PNG");
  EXPECT_EQ(photos[2].name, "b/2.png");
}

}  // namespace
}  // namespace tetrec
