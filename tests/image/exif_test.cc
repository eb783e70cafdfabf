// Notes in EXIF about pixels and cameras.
#include "image/exif.h"

#include "image/exif_block.h"
#include "image/image.h"
#include "image/photo.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace tetrec {
namespace {

int OrientationOf(const std::vector<uint8_t>& app1) { return PixelNotesOfExif(app1).orientation; }

TEST(Exif, TheOrientationIsReadInBothByteOrders) {
  for (const bool is_big_endian : {false, true}) {
    for (int orientation = 1; orientation <= 8; ++orientation) {
      const std::vector<uint8_t> exif = ExifOfOrientation(uint32_t(orientation), is_big_endian);
      EXPECT_EQ(OrientationOf(exif), orientation) << is_big_endian;
    }
  }
}

TEST(Exif, AnOrientationThatIsNoneOrIsDamagedIsOne) {
  for (const bool is_big_endian : {false, true}) {
    for (const uint32_t invalid : {0u, 9u, 6u << 8, 65535u}) {
      EXPECT_EQ(OrientationOf(ExifOfOrientation(invalid, is_big_endian)), 1) << invalid;
    }
    const std::vector<uint8_t> whole = ExifOfOrientation(6, is_big_endian);
    constexpr size_t kBehindOrientation = 26;
    for (size_t length = 0; length <= whole.size(); ++length) {
      std::vector<uint8_t> cut = whole;
      cut.resize(length);
      EXPECT_EQ(OrientationOf(cut), length < kBehindOrientation ? 1 : 6) << length;
    }
  }
  const auto with = [](size_t place, std::vector<uint8_t> bytes) {
    std::vector<uint8_t> exif = ExifOfOrientation(6);
    std::copy(bytes.begin(), bytes.end(), exif.begin() + std::ptrdiff_t(place));
    return OrientationOf(exif);
  };
  EXPECT_EQ(with(0, {'e'}), 1) << "mark";
  EXPECT_EQ(with(6, {'M'}), 1) << "byte order";
  EXPECT_EQ(with(8, {43}), 1) << "version";
  EXPECT_EQ(with(10, {0xFF, 0xFF, 0xFF, 0xFF}), 1) << "directory beyond the end";
  EXPECT_EQ(with(14, {0, 0}), 1) << "no entries";
  EXPECT_EQ(with(14, {0xFF, 0xFF}), 6) << "more entries than there are, behind the orientation";
  EXPECT_EQ(with(14, {0xFF, 0xFF, 0x13}), 1) << "more entries than there are, none of them right";
  EXPECT_EQ(with(18, {4}), 1) << "another type";
  EXPECT_EQ(with(20, {2}), 1) << "two orientations";
}

TEST(Exif, AdobeRgbIsReadInBothByteOrders) {
  for (const bool is_big_endian : {false, true}) {
    const std::vector<uint8_t> adobe = ExifOfIndex("R03", is_big_endian);
    EXPECT_TRUE(PixelNotesOfExif(adobe).are_adobe_rgb);
    EXPECT_FALSE(PixelNotesOfExif(ExifOfIndex("R98", is_big_endian)).are_adobe_rgb);
    const std::vector<uint8_t> converted = ExifOfIndex("R03", is_big_endian, 1);
    EXPECT_FALSE(PixelNotesOfExif(converted).are_adobe_rgb) << "converted to sRGB";
    constexpr size_t kBehindIndex = 76;
    for (size_t length = 0; length <= adobe.size(); ++length) {
      const std::vector<uint8_t> cut(adobe.begin(), adobe.begin() + std::ptrdiff_t(length));
      EXPECT_EQ(PixelNotesOfExif(cut).are_adobe_rgb, length >= kBehindIndex) << length;
    }
  }
  for (const size_t place : {24, 54}) {  // of a directory that is at the end of all bytes
    std::vector<uint8_t> astray = ExifOfIndex("R03");
    std::fill_n(astray.begin() + std::ptrdiff_t(place), 4, uint8_t(0xFF));
    EXPECT_FALSE(PixelNotesOfExif(astray).are_adobe_rgb) << place;
  }
}

// OpenCV, which turns images upright on request, is the second method.
TEST(Exif, QuarterTurnsMakeImagesUpright) {
  Image stored = MakeImage(64, 48, 3);
  for (size_t i = 0; i < stored.pixels.size(); ++i) stored.pixels[i] = uint8_t(i * i / 97);
  const std::vector<uint8_t> jpeg = EncodeJpeg(stored, 95);
  for (int orientation = 1; orientation <= 8; ++orientation) {
    const std::vector<uint8_t> bytes = WithApp1(jpeg, ExifOfOrientation(uint32_t(orientation)));
    const Image upright = DecodeImage(bytes, "a.jpg", ExifRotation::kApply);
    const Image turned = TurnedClockwise(DecodeImage(bytes, "a.jpg"), QuarterTurnsOf(orientation));
    ASSERT_EQ(turned.width, upright.width) << orientation;
    const bool is_mirrored =
        orientation == 2 || orientation == 4 || orientation == 5 || orientation == 7;
    for (int y = 0; y < upright.height; ++y) {
      for (int x = 0; x < upright.width; ++x) {
        const int from = is_mirrored ? upright.width - 1 - x : x;
        ASSERT_EQ(turned.At(from, y)[0], upright.At(x, y)[0])
            << orientation << ' ' << x << ' ' << y;
      }
    }
  }
}

TEST(Exif, APhotoIsReadAsStoredWithItsOrientationWhateverItsExifIs) {
  const ScratchFolder folder;
  const std::vector<uint8_t> jpeg = EncodeJpeg(MakeImage(24, 16, 3), 90);
  const auto orientation_of = [&](const std::vector<uint8_t>& bytes) {
    PhotoNotes notes;
    const Image image = ReadPhoto(folder.Write("a.jpg", bytes), &notes);
    EXPECT_EQ(image.width, 24);
    return notes.orientation;
  };
  EXPECT_EQ(orientation_of(jpeg), 1);
  EXPECT_EQ(orientation_of(WithApp1(jpeg, ExifOfOrientation(6))), 6);
  const std::vector<uint8_t> turned = WithApp1(jpeg, ExifOfOrientation(8, true));
  EXPECT_EQ(orientation_of(turned), 8);
  EXPECT_EQ(orientation_of(WithApp1(jpeg, {})), 1);
  std::vector<uint8_t> cut = ExifOfOrientation(6);
  cut.resize(20);
  EXPECT_EQ(orientation_of(WithApp1(jpeg, cut)), 1);
  // Other programs use the same segment.
  const std::string xmp("http://ns.adobe.com/xap/1.0/\0<x/>", 33);
  EXPECT_EQ(orientation_of(WithApp1(turned, {xmp.begin(), xmp.end()})), 8);

  PhotoNotes of_png;
  WriteImage(folder / "a.png", MakeImage(4, 4, 3));
  ReadPhoto(folder / "a.png", &of_png);
  EXPECT_EQ(of_png.orientation, 1);
}

CameraNotes NotesOfPhoto(const std::vector<uint8_t>& jpeg) {
  const ScratchFolder folder;
  PhotoNotes notes;
  ReadPhoto(folder.Write("a.jpg", jpeg), &notes);
  return notes.camera;
}

TEST(Exif, TheCameraIsReadAsItIsWritten) {
  const std::vector<uint8_t> jpeg = EncodeJpeg(MakeImage(8, 8, 3), 90);
  CameraNotes notes{"Acme", "P1", 4.25, 26, 1};
  EXPECT_EQ(NotesOfPhoto(WithExif(jpeg, notes)), notes);
  EXPECT_EQ(NotesOfPhoto(WithExif(jpeg, {})), CameraNotes{});
  EXPECT_EQ(NotesOfPhoto(jpeg), CameraNotes{});
  notes.model = std::string(1000, 'x');
  EXPECT_EQ(NotesOfPhoto(WithExif(jpeg, notes)).model, std::string(100, 'x'));
}

TEST(Exif, TextsThatAnEntryContainsItselfOrThatAreDamagedAreReadWithinTheirBounds) {
  const auto make_of = [](uint32_t type, uint32_t count, uint32_t value) {
    ExifBlock exif(false);
    exif.Put(1, 2);
    exif.PutEntry(0x010F, type, count);
    exif.Put(value, 4);
    return CameraNotesOfExif(exif.bytes()).make;
  };
  constexpr uint32_t kLg = 'L' | 'G' << 8, kEnd = 24;  // of all bytes, from the byte order on
  EXPECT_EQ(make_of(2, 3, kLg), "LG");
  EXPECT_EQ(make_of(2, 0, kLg), "");
  EXPECT_EQ(make_of(3, 3, kLg), "") << "another type";
  EXPECT_EQ(make_of(2, 0xFFFFFFFF, kEnd), "");
  EXPECT_EQ(make_of(2, 0xFFFFFFFF, 0xFFFFFFFF), "");
  EXPECT_EQ(make_of(2, 0xFFFFFFFF, 0), "") << "where the byte order is";
  EXPECT_EQ(make_of(2, 0xFFFFFFFF, 1), "I*");
}

TEST(Exif, TheDigitalZoomIsReadInBothByteOrders) {
  for (const bool is_big_endian : {false, true}) {
    const std::vector<uint8_t> zoomed = ExifOfDigitalZoom(250, 100, is_big_endian);
    for (size_t length = 0; length <= zoomed.size(); ++length) {
      const std::vector<uint8_t> cut(zoomed.begin(), zoomed.begin() + std::ptrdiff_t(length));
      EXPECT_EQ(CameraNotesOfExif(cut).digital_zoom, length < zoomed.size() ? 1 : 2.5) << length;
    }
  }
  // EXIF has 0 for a zoom that was not used.
  for (const uint32_t none : {0u, 1u}) {
    EXPECT_EQ(CameraNotesOfExif(ExifOfDigitalZoom(none, 1)).digital_zoom, 1);
    EXPECT_EQ(CameraNotesOfExif(ExifOfDigitalZoom(none, 0)).digital_zoom, 1);
  }
}

}  // namespace
}  // namespace tetrec
