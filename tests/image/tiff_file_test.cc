// TIFF files, and the EXIF that is made of theirs.
#include "image/tiff_file.h"

#include "core/error.h"
#include "core/file.h"
#include "expect_error.h"
#include "image/image.h"
#include "image/photo.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <cstring>
#include <map>

namespace tetrec {
namespace {

std::vector<uint8_t> Encode(const cv::Mat& pixels) {
  std::vector<uint8_t> bytes;
  cv::imencode(".tiff", pixels, bytes);
  return bytes;
}

struct Entry {
  uint16_t type = 3;  // short; 4: long
  uint32_t count = 1, value = 0;
};

// A file of 3 x 2 grey pixels 10, 20 .. 60; `other` entries of its directory replace the usual
// ones. What is behind the directory begins at byte 150 or later.
std::vector<uint8_t> GreyTiff(const std::map<uint16_t, Entry>& other = {},
                              const std::string& behind = "") {
  std::map<uint16_t, Entry> entries = {{256, {3, 1, 3}}, {257, {3, 1, 2}}, {258, {3, 1, 8}},
                                       {259, {3, 1, 1}}, {262, {3, 1, 1}}, {273, {4, 1, 8}},
                                       {277, {3, 1, 1}}, {278, {3, 1, 2}}, {279, {4, 1, 6}}};
  for (const auto& [tag, entry] : other) entries[tag] = entry;
  ByteWriter file;
  file.WriteArray<char>(std::string("II*\0", 4));
  file.Write(uint32_t(16));
  for (int i = 1; i <= 8; ++i) file.Write(uint8_t(10 * i));
  file.Write(uint16_t(entries.size()));
  for (const auto& [tag, entry] : entries) {
    file.Write(tag);
    file.Write(entry.type);
    file.Write(entry.count);
    file.Write(entry.value);
  }
  file.Write(uint32_t(0));
  file.WriteArray<char>(behind);
  return file.bytes();
}

TEST(TiffFiles, PixelsOfEightAndSixteenBitsAreRead) {
  cv::Mat eight(5, 4, CV_8UC3), sixteen(5, 4, CV_16UC3);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 4; ++x) {
      eight.at<cv::Vec3b>(y, x) = {uint8_t(10 * x), uint8_t(20 * y), 200};  // blue, green, red
      sixteen.at<cv::Vec3w>(y, x) = {uint16_t(2570 * x + 100), uint16_t(5140 * y), 51400};
    }
  }
  for (const cv::Mat& pixels : {eight, sixteen}) {
    const Image image = DecodeImage(Encode(pixels), "a.tif");
    ASSERT_EQ(image.width, 4);
    ASSERT_EQ(image.height, 5);
    ASSERT_EQ(image.channels, 3);
    EXPECT_EQ(image.At(3, 1)[0], 200);
    EXPECT_EQ(image.At(3, 1)[1], 20);
    EXPECT_EQ(image.At(3, 1)[2], 30);  // 100 of 65,535 are less than half a level
  }
}

TEST(TiffFiles, AnOrientationTurnsNothing) {
  for (const uint32_t orientation : {1u, 3u, 6u, 8u}) {
    const Image image = DecodeImage(GreyTiff({{274, {3, 1, orientation}}}), "a.tif");
    ASSERT_EQ(image.width, 3) << orientation;
    EXPECT_EQ(image.At(0, 0)[0], 10) << orientation;
    EXPECT_EQ(image.At(2, 1)[0], 60) << orientation;
  }
}

TEST(TiffFiles, AnOrientationIsRead) {
  EXPECT_EQ(OrientationOfTiff(GreyTiff(), "a.tif"), 1);
  for (uint32_t orientation = 1; orientation <= 8; ++orientation) {
    const std::vector<uint8_t> tiff = GreyTiff({{274, {3, 1, orientation}}});
    EXPECT_EQ(OrientationOfTiff(tiff, "a.tif"), int(orientation));
  }
  for (const uint32_t invalid : {0u, 9u, 65535u}) {
    const std::vector<uint8_t> tiff = GreyTiff({{274, {3, 1, invalid}}});
    EXPECT_EQ(OrientationOfTiff(tiff, "a.tif"), 1) << invalid;
  }
  const ScratchFolder folder;
  PhotoNotes notes;
  const Image image = ReadPhoto(folder.Write("a.tif", GreyTiff({{274, {3, 1, 6}}})), &notes);
  EXPECT_EQ(image.width, 3);
  EXPECT_EQ(notes.orientation, 6);
}

TEST(TiffFiles, AlphaIsStraight) {
  cv::Mat pixels(1, 1, CV_8UC4, cv::Scalar(30, 60, 90, 128));
  const Image image = DecodeImage(Encode(pixels), "a.tif");
  if (image.channels == 3) GTEST_SKIP() << "OpenCV does not mark its fourth channel as alpha";
  EXPECT_EQ(image.At(0, 0)[3], 128);
}

TEST(TiffFiles, DamagedAndStrangeFilesAreRefusedWithTheirName) {
  const auto refused = [](std::vector<uint8_t> bytes, const std::string& why) {
    ExpectError<DataError>([&] { DecodeImage(bytes, "a.tif"); }, {"a.tif: ", why});
  };
  std::vector<uint8_t> cut = Encode(cv::Mat(50, 50, CV_8UC3, cv::Scalar(5, 6, 7)));
  cut.resize(cut.size() / 2);
  refused(cut, "damaged");
  refused(GreyTiff({{273, {4, 1, 100000}}}), "damaged");
  refused(GreyTiff({{256, {4, 1, 0}}}), "damaged");
  refused(GreyTiff({{256, {4, 1, 100000}}}), "100000 x 2 pixels");
  refused(GreyTiff({{256, {4, 1, 16000}}, {257, {4, 1, 16000}}}), "cannot contain");
  refused(GreyTiff({{258, {3, 1, 32}}, {339, {3, 1, 3}}}), "8 or 16 bits");
  refused(GreyTiff({{339, {3, 1, 2}}}), "8 or 16 bits");
  refused(GreyTiff({{322, {4, 1, 1u << 30}}, {323, {4, 1, 1u << 30}}, {324, {4, 1, 8}}}), "");
  refused(
      GreyTiff({{322, {4, 1, 16384}}, {323, {4, 1, 16384}}, {324, {4, 1, 8}}, {325, {4, 1, 6}}}),
      "tile of 268435456 bytes for 6 pixels");
}

TEST(TiffFiles, TheFocalLengthReachesTheJpegForColmap) {
  // Nine entries and three more are 150 bytes; the directory ends at byte 16 + 150.
  constexpr uint32_t kBehind = 16 + 2 + 12 * 12 + 4;
  ByteWriter behind;
  behind.WriteArray<char>(std::string("Leica Camera\0\0", 14));
  behind.Write(uint16_t(3));  // the directory of EXIF, at kBehind + 14
  for (const uint32_t value : {0x920Au | 5u << 16, 1u, kBehind + 14 + 42, 0xA404u | 5u << 16, 1u,
                               kBehind + 14 + 50, 0xA405u | 3u << 16, 1u, 28u})
    behind.Write(value);
  for (const uint32_t value : {0u, 85u, 10u, 3u, 2u}) behind.Write(value);
  const std::string text(behind.bytes().begin(), behind.bytes().end());
  const std::vector<uint8_t> tiff = GreyTiff(
      {{271, {2, 13, kBehind}}, {272, {2, 3, 'M' | '3' << 8}}, {34665, {4, 1, kBehind + 14}}},
      text);
  const CameraNotes notes = CameraNotesOfTiff(tiff, "a.tif");
  EXPECT_EQ(notes.make, "Leica Camera");
  EXPECT_EQ(notes.model, "M3");
  EXPECT_NEAR(notes.focal_length_mm, 8.5, 1e-6);
  EXPECT_EQ(notes.focal_length_35mm, 28);
  EXPECT_EQ(notes.digital_zoom, 1.5);
  const ScratchFolder folder;
  PhotoNotes of_file;
  ReadPhoto(folder.Write("a.tif", tiff), &of_file);
  EXPECT_EQ(of_file.camera, notes);

  const std::vector<uint8_t> jpeg = WithExif(EncodeJpeg(MakeImage(8, 8, 3), 90), notes);
  EXPECT_EQ(DecodeImage(jpeg, "a.jpg").width, 8);
  const std::string content(jpeg.begin(), jpeg.end());
  const size_t mark = content.find(std::string("Exif\0\0II*\0", 10));
  ASSERT_NE(mark, std::string::npos);
  const std::string exif = content.substr(mark + 6);
  EXPECT_NE(exif.find(std::string("Leica Camera\0", 13)), std::string::npos);
  EXPECT_NE(exif.find(std::string("M3\0", 3)), std::string::npos);
  // The entry has tag, type, count and where the rational number is.
  const size_t entry = exif.find(std::string("\x0A\x92\x05\0\x01\0\0\0", 8));
  ASSERT_NE(entry, std::string::npos);
  const auto number_at = [&](size_t at) {
    uint32_t number = 0;
    std::memcpy(&number, &exif.at(at), sizeof(number));
    return number;
  };
  const size_t rational = number_at(entry + 8);
  EXPECT_NEAR(double(number_at(rational)) / number_at(rational + 4), 8.5, 1e-3);
  EXPECT_NE(exif.find(std::string("\x05\xA4\x03\0\x01\0\0\0\x1C\0\0\0", 12)), std::string::npos)
      << "28 mm";
}

}  // namespace
}  // namespace tetrec
