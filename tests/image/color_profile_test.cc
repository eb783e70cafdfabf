// Colour profiles of photos.
#include "image/color_profile.h"

#include "core/file.h"
#include "image/exif_block.h"
#include "image/image.h"
#include "image/photo.h"
#include "image/srgb.h"
#include "scratch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <lcms2.h>
#include <opencv2/imgcodecs.hpp>
#include <tiffio.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>

namespace tetrec {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<uint8_t> BytesOf(cmsHPROFILE profile) {
  cmsUInt32Number size = 0;
  EXPECT_TRUE(cmsSaveProfileToMem(profile, nullptr, &size));
  std::vector<uint8_t> bytes(size);
  EXPECT_TRUE(cmsSaveProfileToMem(profile, bytes.data(), &size));
  cmsCloseProfile(profile);
  return bytes;
}

cmsToneCurve* SrgbCurve() {
  const std::array<double, 5> parameters = {2.4, 1 / 1.055, 0.055 / 1.055, 1 / 12.92, 0.04045};
  return cmsBuildParametricToneCurve(nullptr, 4, parameters.data());
}

// Display P3: its own primaries, the white and the curve of sRGB.
std::vector<uint8_t> DisplayP3() {
  const cmsCIExyY white{0.3127, 0.3290, 1};
  const cmsCIExyYTRIPLE primaries{{0.680, 0.320, 1}, {0.265, 0.690, 1}, {0.150, 0.060, 1}};
  cmsToneCurve* const curve = SrgbCurve();
  cmsToneCurve* const curves[] = {curve, curve, curve};
  const std::vector<uint8_t> bytes = BytesOf(cmsCreateRGBProfile(&white, &primaries, curves));
  cmsFreeToneCurve(curve);
  return bytes;
}

std::vector<uint8_t> Srgb() { return BytesOf(cmsCreate_sRGBProfile()); }

std::vector<uint8_t> Grey() {
  cmsToneCurve* const curve = SrgbCurve();
  const std::vector<uint8_t> bytes = BytesOf(cmsCreateGrayProfile(cmsD50_xyY(), curve));
  cmsFreeToneCurve(curve);
  return bytes;
}

// Display P3 in sRGB by the matrix of CSS Color 4 (W3C), which does not know profiles.
std::array<uint8_t, 3> SrgbFromP3(const std::array<uint8_t, 3>& p3) {
  constexpr double kMatrix[3][3] = {{1.2249401763, -0.2249401763, 0},
                                    {-0.0420569547, 1.0420569547, 0},
                                    {-0.0196375546, -0.0786360456, 1.0982736001}};
  std::array<uint8_t, 3> srgb;
  for (size_t c = 0; c < 3; ++c) {
    double linear = 0;
    for (size_t k = 0; k < 3; ++k) linear += kMatrix[c][k] * LinearFromSrgb(p3[k] / 255.0);
    srgb[c] =
        uint8_t(std::lround(255 * std::clamp(SrgbFromLinear(std::max(linear, 0.0)), 0.0, 1.0)));
  }
  return srgb;
}

// Some inside and some outside of sRGB; grey is the same in both.
constexpr std::array<std::array<uint8_t, 3>, 6> kColors = {
    {{200, 60, 50}, {40, 160, 90}, {90, 80, 200}, {128, 128, 128}, {250, 20, 10}, {255, 255, 255}}};

cv::Mat Blocks(int channels) {
  constexpr int kBlock = 16;  // so that JPEG leaves each colour alone
  cv::Mat blocks(kBlock, kBlock * int(kColors.size()), CV_8UC(channels));
  for (int y = 0; y < blocks.rows; ++y) {
    for (int x = 0; x < blocks.cols; ++x) {
      uint8_t* pixel = blocks.ptr(y) + x * channels;
      for (int c = 0; c < 3; ++c) pixel[c] = kColors[size_t(x / kBlock)][size_t(2 - c)];
      if (channels == 4) pixel[3] = uint8_t(40 * (x / kBlock));
    }
  }
  return blocks;
}

std::vector<uint8_t> Encoded(const char* extension, const cv::Mat& image) {
  std::vector<uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(extension, image, bytes, {cv::IMWRITE_JPEG_QUALITY, 100}));
  return bytes;
}

// The profile in `parts` parts, the last one first.
std::vector<uint8_t> JpegWith(const std::vector<uint8_t>& profile, size_t parts = 1) {
  std::vector<uint8_t> jpeg = Encoded(".jpg", Blocks(3));
  for (size_t i = 0; i < parts; ++i) {
    const size_t begin = profile.size() * i / parts, end = profile.size() * (i + 1) / parts;
    std::vector<uint8_t> segment = {0xFF, 0xE2, uint8_t((end - begin + 16) >> 8),
                                    uint8_t(end - begin + 16)};
    for (const char c : std::string("ICC_PROFILE\0", 12)) segment.push_back(uint8_t(c));
    segment.push_back(uint8_t(i + 1));
    segment.push_back(uint8_t(parts));
    segment.insert(segment.end(), profile.begin() + ptrdiff_t(begin),
                   profile.begin() + ptrdiff_t(end));
    jpeg.insert(jpeg.begin() + 2, segment.begin(), segment.end());
  }
  return jpeg;
}

void Append32(std::vector<uint8_t>& bytes, uint32_t number) {
  for (const int shift : {24, 16, 8, 0}) bytes.push_back(uint8_t(number >> shift));
}

std::vector<uint8_t> PngWith(const std::vector<uint8_t>& profile, int channels = 3) {
  std::vector<uint8_t> compressed(compressBound(profile.size()));
  uLongf size = compressed.size();
  EXPECT_EQ(compress(compressed.data(), &size, profile.data(), profile.size()), Z_OK);
  std::vector<uint8_t> body = {'i', 'C', 'C', 'P', 'P', '3', 0, 0}, chunk;
  body.insert(body.end(), compressed.begin(), compressed.begin() + ptrdiff_t(size));
  Append32(chunk, uint32_t(body.size() - 4));
  chunk.insert(chunk.end(), body.begin(), body.end());
  Append32(chunk, uint32_t(crc32(0, body.data(), uInt(body.size()))));
  std::vector<uint8_t> png = Encoded(".png", Blocks(channels));
  constexpr ptrdiff_t kBehindHeader = 33;
  png.insert(png.begin() + kBehindHeader, chunk.begin(), chunk.end());
  return png;
}

void WriteTiff(const std::filesystem::path& path, const std::vector<uint8_t>& profile) {
  TIFF* const file = TIFFOpen(path.c_str(), "w");
  ASSERT_NE(file, nullptr);
  TIFFSetField(file, TIFFTAG_IMAGEWIDTH, uint32_t(kColors.size()));
  TIFFSetField(file, TIFFTAG_IMAGELENGTH, uint32_t(1));
  TIFFSetField(file, TIFFTAG_BITSPERSAMPLE, 8);
  TIFFSetField(file, TIFFTAG_SAMPLESPERPIXEL, 3);
  TIFFSetField(file, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_RGB);
  TIFFSetField(file, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(file, TIFFTAG_ICCPROFILE, uint32_t(profile.size()), profile.data());
  auto row = kColors;
  EXPECT_EQ(TIFFWriteScanline(file, row.data(), 0), 1);
  TIFFClose(file);
}

// Each colour of the photo, from the middle of its block, within some levels of the expected one.
void ExpectConverted(const Image& photo, int levels) {
  const int block = photo.width / int(kColors.size());
  for (size_t i = 0; i < kColors.size(); ++i) {
    const uint8_t* pixel = photo.At(int(i) * block + block / 2, photo.height / 2);
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(pixel[c], SrgbFromP3(kColors[i])[c], levels) << "colour " << i << ", " << c;
    }
  }
}

Image Read(const std::filesystem::path& path, ProfileUse expected = ProfileUse::kApplied) {
  ProfileUse use = ProfileUse::kNone;
  Image image = ReadPicture(path, use);
  EXPECT_EQ(use, expected) << path;
  return image;
}

std::string WarningsWhile(const std::function<void()>& work) {
  ::testing::internal::CaptureStderr();
  work();
  return ::testing::internal::GetCapturedStderr();
}

TEST(ColorProfile, ImagesInDisplayP3BecomeSrgb) {
  const ScratchFolder folder;
  const std::vector<uint8_t> p3 = DisplayP3();
  ExpectConverted(Read(folder.Write("a.png", PngWith(p3))), 1);
  ExpectConverted(Read(folder.Write("a.jpg", JpegWith(p3))), 3);
  ExpectConverted(Read(folder.Write("parts.jpg", JpegWith(p3, 3))), 3);
  WriteTiff(folder / "a.tif", p3);
  ExpectConverted(Read(folder / "a.tif"), 1);
  // The colours differ enough for this to mean something.
  EXPECT_GT(std::abs(SrgbFromP3(kColors[0])[0] - kColors[0][0]), 10);
}

// Some cameras write no profile, but an index into EXIF.
TEST(ColorProfile, AJpegWhoseExifNotesAdobeRgbBecomesSrgb) {
  const ScratchFolder folder;
  const std::vector<uint8_t> jpeg = Encoded(".jpg", Blocks(3));
  const Image image = Read(folder.Write("a.jpg", WithApp1(jpeg, ExifOfIndex("R03"))));
  // The matrix that follows from the primaries and the white of both, in linear light.
  constexpr double kMatrix[3][3] = {
      {1.3983557, -0.3983557, 0}, {0, 1, 0}, {0, -0.0429290, 1.0429290}};
  for (size_t i = 0; i < kColors.size(); ++i) {
    for (size_t c = 0; c < 3; ++c) {
      double linear = 0;
      for (size_t k = 0; k < 3; ++k) {
        linear += kMatrix[c][k] * std::pow(kColors[i][k] / 255.0, 563.0 / 256);
      }
      const double srgb = 255 * std::clamp(SrgbFromLinear(std::max(linear, 0.0)), 0.0, 1.0);
      EXPECT_NEAR(image.At(16 * int(i) + 8, 8)[c], srgb, 3) << "colour " << i << ", " << c;
    }
  }
  EXPECT_GT(image.At(8, 8)[0], kColors[0][0] + 10);
  // A profile counts more, and other indices mean sRGB.
  const std::vector<uint8_t> p3 = WithApp1(JpegWith(DisplayP3()), ExifOfIndex("R03"));
  ExpectConverted(Read(folder.Write("p3.jpg", p3)), 3);
  Read(folder.Write("srgb.jpg", WithApp1(JpegWith(Srgb()), ExifOfIndex("R03"))), ProfileUse::kNone);
  Read(folder.Write("b.jpg", WithApp1(jpeg, ExifOfIndex("R98"))), ProfileUse::kNone);
}

TEST(ColorProfile, AlphaStays) {
  const ScratchFolder folder;
  const Image image = Read(folder.Write("a.png", PngWith(DisplayP3(), 4)));
  ASSERT_EQ(image.channels, 4);
  ExpectConverted(image, 1);
  for (int i = 0; i < int(kColors.size()); ++i) EXPECT_EQ(image.At(16 * i + 8, 8)[3], 40 * i);
}

TEST(ColorProfile, SrgbAndWhatIsNotReadForItsColoursStayAsTheyAre) {
  const ScratchFolder folder;
  const std::filesystem::path srgb = folder.Write("srgb.png", PngWith(Srgb()));
  const std::filesystem::path p3 = folder.Write("p3.png", PngWith(DisplayP3()));
  EXPECT_EQ(Read(srgb, ProfileUse::kNone).pixels, ReadImage(srgb).pixels);
  EXPECT_EQ(ReadImage(p3).pixels, ReadImage(srgb).pixels);
  EXPECT_NE(Read(p3).pixels, ReadImage(p3).pixels);
}

// Damage must not go unnoticed, nor change colours.
TEST(ColorProfile, OneThatIsDamagedOrOfAnotherKindIsIgnored) {
  const ScratchFolder folder;
  const auto expect = [&](const std::vector<uint8_t>& file, ProfileUse use) {
    const std::filesystem::path path = folder.Write("image", file);
    EXPECT_EQ(Read(path, use).pixels, ReadImage(path).pixels);
  };
  const std::vector<uint8_t> p3 = DisplayP3();
  std::vector<uint8_t> cut = p3, png = PngWith(p3), jpeg = JpegWith(p3, 3), twice = jpeg;
  cut.resize(150);
  expect(PngWith(cut), ProfileUse::kIgnored);
  expect(PngWith(Grey()), ProfileUse::kIgnored);
  expect(PngWith(std::vector<uint8_t>(5 << 20, 7)), ProfileUse::kIgnored);
  // The last part of the three is the first in the file.
  const size_t part = 2 + size_t(jpeg[4] << 8 | jpeg[5]);
  twice.insert(twice.begin() + 2, jpeg.begin() + 2, jpeg.begin() + 2 + ptrdiff_t(part));
  expect(twice, ProfileUse::kIgnored);
  jpeg.erase(jpeg.begin() + 2, jpeg.begin() + 2 + ptrdiff_t(part));
  expect(jpeg, ProfileUse::kIgnored);
  expect(Encoded(".png", Blocks(3)), ProfileUse::kNone);
}

// Tables may refer to one another without end, and cost gigabytes and hours.
TEST(ColorProfile, TablesBesidePrimariesAndCurvesAreNotRead) {
  const ScratchFolder folder;
  std::vector<uint8_t> with_tables = DisplayP3();
  // The description becomes what it is not: a table of colours. Read, it would be refused.
  const std::string_view name("desc");
  const auto tag =
      std::search(with_tables.begin() + 128, with_tables.end(), name.begin(), name.end());
  ASSERT_NE(tag, with_tables.end());
  std::copy_n("A2B1", 4, tag);
  ExpectConverted(Read(folder.Write("a.png", PngWith(with_tables))), 1);
}

TEST(ColorProfile, EachUseIsLoggedOnce) {
  const auto lines = [](const std::vector<ProfileUse>& uses) {
    return WarningsWhile([&] { LogProfileUses({"a.jpg", "b.jpg", "c.jpg"}, uses); });
  };
  using enum ProfileUse;
  EXPECT_THAT(lines({kNone, kNone, kNone}), IsEmpty());
  EXPECT_THAT(lines({kApplied, kNone, kApplied}),
              HasSubstr("other than sRGB, converted to sRGB: 2"));
  EXPECT_THAT(
      lines({kIgnored, kNone, kIgnored}),
      HasSubstr("images whose colour profile is damaged, or not one of RGB primaries and curves, "
                "read as sRGB: 2 (a.jpg, c.jpg)"));
}

}  // namespace
}  // namespace tetrec
