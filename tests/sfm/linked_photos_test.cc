// Photos as COLMAP reads them: which of them share a camera.
#include "sfm/linked_photos.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

namespace tetrec {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

const CameraNotes kPhone{"Acme", "P1", 4.25, 26, 1};

Photo PhotoOf(const CameraNotes& notes, const std::string& name = "a.jpg") {
  Photo photo;
  photo.name = name;
  photo.for_colmap = name;
  photo.width = 64;
  photo.height = 48;
  photo.camera = notes;
  return photo;
}

std::vector<size_t> PhotosOfCameras(const std::vector<Photo>& photos, CameraSharing sharing) {
  const ScratchFolder folder;
  return LinkPhotos(photos, sharing, folder / "links").photos_of_camera;
}

TEST(LinkPhotos, PhotosOfOneSizeShareACameraIfTheirExifDoesNotDiffer) {
  std::vector<Photo> photos = {PhotoOf(kPhone), PhotoOf(kPhone)};
  EXPECT_THAT(PhotosOfCameras(photos, CameraSharing::kAuto), ElementsAre(2));
  const auto add = [&](const auto& change) {
    CameraNotes other = kPhone;
    change(other);
    photos.push_back(PhotoOf(other));
  };
  add([](CameraNotes& other) { other.make = "Other"; });
  add([](CameraNotes& other) { other.model = "P2"; });
  add([](CameraNotes& other) { other.focal_length_mm = 6.5; });
  add([](CameraNotes& other) { other.focal_length_35mm = 52; });
  add([](CameraNotes& other) { other.digital_zoom = 2; });
  add([](CameraNotes& other) { other = {}; });
  photos.push_back(PhotoOf({}));
  EXPECT_THAT(PhotosOfCameras(photos, CameraSharing::kAuto), ElementsAre(2, 1, 1, 1, 1, 1, 2));
  photos[0].width = 48;
  EXPECT_EQ(PhotosOfCameras(photos, CameraSharing::kAuto).size(), 8u);
}

TEST(LinkPhotos, SharingThatWasAskedForIgnoresExif) {
  CameraNotes zoomed = kPhone;
  zoomed.digital_zoom = 2;
  const std::vector<Photo> photos = {PhotoOf(kPhone, "a/1.jpg"), PhotoOf(zoomed, "a/2.jpg"),
                                     PhotoOf(zoomed, "b/1.jpg")};
  EXPECT_THAT(PhotosOfCameras(photos, CameraSharing::kSingle), ElementsAre(3));
  EXPECT_THAT(PhotosOfCameras(photos, CameraSharing::kPerFolder), ElementsAre(2, 1));
  EXPECT_THAT(PhotosOfCameras(photos, CameraSharing::kPerImage), ElementsAre(1, 1, 1));
}

TEST(LinkPhotos, OneCameraCannotHaveSeveralSizes) {
  std::vector<Photo> photos = {PhotoOf({}), PhotoOf({})};
  photos[0].width = 32;
  ExpectError<DataError>([&] { PhotosOfCameras(photos, CameraSharing::kSingle); },
                         {"the photos have 2 different sizes", "sharing auto"});
}

// A file in the place of the link stands in for a file system without links.
TEST(LinkOrCopy, APhotoThatCannotBeLinkedIsCopied) {
  const ScratchFolder folder;
  const fs::path photo = folder.Write("a.jpg", "photo");
  EXPECT_TRUE(LinkOrCopy(photo, folder / "1.jpg"));
  EXPECT_TRUE(fs::is_symlink(folder / "1.jpg"));
  const fs::path taken = folder.Write("2.jpg", "");
  EXPECT_FALSE(LinkOrCopy(photo, taken));
  EXPECT_FALSE(fs::is_symlink(taken));
  EXPECT_EQ(ReadText(taken), "photo");
}

TEST(LinkOrCopy, APhotoThatCannotBeCopiedEitherNamesTheFileSystem) {
  const ScratchFolder folder;
  const fs::path photo = folder.Write("a.jpg", "photo");
  ExpectError<EnvironmentError>(
      [&] { LinkOrCopy(photo, folder / "missing/1.jpg"); },
      {"missing/1.jpg: ", "a.jpg can be neither linked (No such file or directory) nor copied",
       "the file system of the run folder"});
}

}  // namespace
}  // namespace tetrec
