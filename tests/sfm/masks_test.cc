// Masks of photos: which belongs to which, and which cannot be used.
#include "sfm/masks.h"

#include "core/error.h"
#include "core/log.h"
#include "expect_error.h"
#include "scratch_folder.h"
#include "sfm/write_photo.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tetrec {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class MasksTest : public ::testing::Test {
 protected:
  void SetUp() override { TakeWarnings(); }

  // Black, but for the columns from `first_seen` on.
  void WriteMask(const std::string& name, int first_seen, int width = 64, int height = 48,
                 uint8_t white = 255) {
    Image mask = MakeImage(width, height, 3);
    for (int y = 0; y < height; ++y) {
      for (int x = first_seen; x < width; ++x) std::fill_n(mask.At(x, y), 3, white);
    }
    const fs::path path = fs::path(masks_) / name;
    fs::create_directories(path.parent_path());
    WriteImage(path, mask);
  }

  static std::vector<Photo> Photos(const std::vector<std::string>& names) {
    std::vector<Photo> photos;
    for (const std::string& name : names) {
      Photo photo;
      photo.name = name;
      photo.width = 64;
      photo.height = 48;
      photos.push_back(photo);
    }
    return photos;
  }

  ScratchFolder folder_;
  const std::string masks_ = folder_ / "masks";
};

TEST_F(MasksTest, AMaskIsNamedLikeItsPhotoOrAsColmapNamesIt) {
  for (const char* name : {"a.png", "sub/b.JPG.png", "c.v2.jpg", "d.png", "d.jpg.png", "other.png"})
    WriteMask(name, 0);
  const std::vector<fs::path> masks =
      FindMasks(masks_, Photos({"a.jpg", "sub/b.JPG", "c.v2.jpeg", "d.jpg"}));
  ASSERT_EQ(masks.size(), 4u);
  EXPECT_EQ(masks[0], fs::path(masks_) / "a.png");
  EXPECT_EQ(masks[1], fs::path(masks_) / "sub/b.JPG.png");
  EXPECT_EQ(masks[2], fs::path(masks_) / "c.v2.jpg");
  EXPECT_EQ(masks[3], fs::path(masks_) / "d.jpg.png");
}

TEST_F(MasksTest, EachPhotoNeedsOneMaskOfItsOwn) {
  ExpectError<DataError>([&] { FindMasks(masks_, Photos({"a.jpg"})); }, {"is not a folder"});
  WriteMask("a.png", 0);
  ExpectError<DataError>(
      [&] {
        FindMasks(masks_, Photos({"a.jpg", "b.jpg", "sub/a.jpg"}));
      },
      {"2 of 3 photos have no mask: b.jpg, sub/a.jpg", "b.jpg.png"});
  ExpectError<DataError>(
      [&] {
        FindMasks(masks_, Photos({"a.jpg", "a.png"}));
      },
      {"a.png is the mask of both a.jpg and a.png", "a.jpg.png"});
  WriteMask("a.jpg", 0);
  ExpectError<DataError>([&] { FindMasks(masks_, Photos({"a.JPG"})); },
                         {"a.JPG has 2 masks (a.jpg, a.png)"});
}

TEST_F(MasksTest, AScaledCopyIsResampledAndAnotherShapeRefused) {
  WriteMask("half.png", 16, 32, 24);
  const Photo photo = Photos({"a.jpg"})[0];
  const std::vector<uint8_t> levels = ReadMask(fs::path(masks_) / "half.png", photo);
  ASSERT_EQ(levels.size(), 64u * 48u);
  EXPECT_EQ(levels[30], 0);
  EXPECT_EQ(levels[33], 255);
  WriteMask("turned.png", 0, 48, 64);
  ExpectError<DataError>([&] { ReadMask(fs::path(masks_) / "turned.png", photo); },
                         {"turned.png: mask of 48 x 64 pixels for a photo of 64 x 48"});
  WriteMask("bits.png", 10, 64, 48, 1);  // of 0 and 1
  EXPECT_EQ(ReadMask(fs::path(masks_) / "bits.png", photo)[10], 255);
}

TEST_F(MasksTest, AreAsPhotosAreStoredOrAllUpright) {
  const auto photos_with_turns = [] {
    std::vector<Photo> photos = Photos({"a.jpg", "b.jpg", "c.jpg"});
    photos[0].quarter_turns = 1;  // its left is up
    photos[1].quarter_turns = 2;  // its bottom is
    return photos;
  };
  for (const char* name : {"a.png", "b.png", "c.png"}) WriteMask(name, 16);
  std::vector<Photo> stored = photos_with_turns();
  AddMasks(masks_, stored);
  const auto seen_at_left = [](const Photo& photo) { return ReadMask(photo.mask, photo)[0] > 0; };
  for (const Photo& photo : stored) EXPECT_FALSE(seen_at_left(photo)) << photo.name;

  WriteImage(fs::path(masks_) / "a.png", TurnedClockwise(ReadImage(fs::path(masks_) / "a.png"), 1));
  std::vector<Photo> upright = photos_with_turns();
  AddMasks(masks_, upright);
  EXPECT_FALSE(seen_at_left(upright[0]));
  EXPECT_TRUE(seen_at_left(upright[1])) << "its mask is upright, too";
  EXPECT_FALSE(seen_at_left(upright[2]));

  WriteMask("a.png", 0, 48, 63);
  std::vector<Photo> other = photos_with_turns();
  ExpectError<DataError>([&] { AddMasks(masks_, other); },
                         {"a.png: mask of 48 x 63 pixels for a photo of 64 x 48"});
}

TEST_F(MasksTest, AllMasksThatCannotBeUsedAreNamedAtOnce) {
  WriteMask("a.png", 5);
  WriteMask("b.png", 5, 64, 40);
  folder_.Write("masks/c.png", "this is a text");
  std::vector<Photo> photos = Photos({"a.jpg", "b.jpg", "c.jpg"});
  ExpectError<DataError>([&] { AddMasks(masks_, photos); },
                         {"2 of 3 masks cannot be used: ", "b.png: mask of 64 x 40", "c.png: not"});
}

TEST_F(MasksTest, APhotoWhoseMaskLeavesNoPixelIsLeftOut) {
  WriteMask("a.png", 5);
  WriteMask("b.png", 0, 64, 48, 127);
  WriteMask("c.png", 64);
  WriteMask("d.png", 0);
  WriteMask("e.png", 0);
  std::vector<Photo> photos = Photos({"a.jpg", "b.jpg", "c.jpg", "d.jpg", "e.jpg"});
  EXPECT_THAT(AddMasks(masks_, photos), ElementsAre("b.jpg", "c.jpg"));
  EXPECT_THAT(TakeWarnings(), ElementsAre(HasSubstr("left out: 2: b.jpg, c.jpg")));
  ASSERT_EQ(photos.size(), 3u);
  EXPECT_EQ(photos[1].name, "d.jpg");
  EXPECT_EQ(photos[1].mask, fs::path(masks_) / "d.png");
  EXPECT_EQ(photos[1].mask_sha256.size(), 64u);
  photos = Photos({"a.jpg", "b.jpg", "c.jpg", "d.jpg"});
  ExpectError<DataError>([&] { AddMasks(masks_, photos); },
                         {"the masks of 2 of 4 photos leave no pixel", "inverted"});
}

TEST_F(MasksTest, MasksThatHideNothingAreNoMasks) {
  WriteMask("a.png", 0);
  WriteMask("b.png", 0, 32, 24);
  std::vector<Photo> photos = Photos({"a.jpg", "b.jpg"});
  EXPECT_TRUE(AddMasks(masks_, photos).empty());
  ASSERT_EQ(photos.size(), 2u);
  EXPECT_TRUE(photos[0].mask.empty());
}

TEST_F(MasksTest, ColmapGetsBlackAndWhiteAndTheSceneGetsAlpha) {
  WriteMask("a.png", 40, 64, 48, 130);
  Photo photo = Photos({"a.jpg"})[0];
  photo.mask = fs::path(masks_) / "a.png";
  WriteColmapMask(folder_ / "0.jpg.png", photo);
  const Image written = ReadImage(folder_ / "0.jpg.png");
  EXPECT_EQ(written.At(39, 7)[0], 0);
  EXPECT_EQ(written.At(40, 7)[0], 255);
  Image rgb = MakeImage(64, 48, 3);
  rgb.At(39, 7)[1] = 99;
  const Image masked = MaskedPhoto(rgb, photo);
  ASSERT_EQ(masked.channels, 4);
  EXPECT_EQ(masked.At(39, 7)[1], 99);
  EXPECT_EQ(masked.At(39, 7)[3], 0);
  EXPECT_EQ(masked.At(40, 7)[3], 130);
}

}  // namespace
}  // namespace tetrec
