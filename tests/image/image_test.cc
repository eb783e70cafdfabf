// Images: their files, area means, compositing and masks.
#include "image/image.h"

#include "core/error.h"
#include "core/file.h"
#include "core/message_of.h"
#include "expect_error.h"
#include "file_size_limit.h"
#include "image/exif_block.h"
#include "image/resize.h"
#include "scratch_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <random>

namespace tetrec {
namespace {

Image RandomImage(int width, int height, int channels, uint32_t seed) {
  std::mt19937 generator(seed);
  Image image = MakeImage(width, height, channels);
  for (uint8_t& value : image.pixels) value = uint8_t(generator());
  return image;
}

// An image of gradients, which JPEG preserves well.
Image SmoothImage(int width, int height) {
  Image image = MakeImage(width, height, 3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.At(x, y)[0] = uint8_t(255 * x / width);
      image.At(x, y)[1] = uint8_t(255 * y / height);
      image.At(x, y)[2] = 128;
    }
  }
  return image;
}

std::vector<uint8_t> Encode(const std::string& extension, const cv::Mat& mat,
                            const std::vector<int>& parameters = {}) {
  std::vector<uint8_t> bytes;
  EXPECT_TRUE(cv::imencode(extension, mat, bytes, parameters));
  return bytes;
}

std::vector<uint8_t> SomeJpeg(const std::vector<int>& parameters = {}) {
  cv::Mat mat(48, 64, CV_8UC3);
  cv::randu(mat, 0, 255);
  return Encode(".jpg", mat, parameters);
}

const std::vector<uint8_t> kQuarterTurn = ExifOfOrientation(6);

void ExpectTruncated(std::vector<uint8_t> bytes, size_t length, const std::string& part = "") {
  bytes.resize(length);
  ExpectError<DataError>([&] { DecodeImage(bytes, "cut"); }, {"cut: ", part});
}

// A second method: every pixel is split into target_w x target_h equal parts, so that each target
// pixel is the mean of source_w x source_h whole parts.
double MeanOfParts(const Image& image, int width, int height, int x, int y, int channel) {
  double colour = 0, weight = 0;
  for (int j = 0; j < image.height; ++j) {
    for (int i = 0; i < image.width; ++i) {
      const uint8_t* pixel =
          image.At((x * image.width + i) / width, (y * image.height + j) / height);
      const double alpha = image.channels == 4 ? pixel[3] : 1;
      weight += channel == 3 ? 1 : alpha;
      colour += channel == 3 ? alpha : alpha * pixel[channel];
    }
  }
  return weight > 0 ? colour / weight : 0;
}

TEST(ResizeByArea, EqualsTheMeanOverEqualPartsOfThePixels) {
  const int sizes[][4] = {{8, 8, 4, 4}, {9, 7, 4, 3}, {5, 5, 3, 2}, {3, 2, 7, 5}, {13, 4, 1, 1}};
  for (const int channels : {3, 4}) {
    for (const auto& size : sizes) {
      const Image image = RandomImage(size[0], size[1], channels, 7);
      const Image target = ResizeByArea(image, size[2], size[3]);
      ASSERT_EQ(target.width, size[2]);
      ASSERT_EQ(target.height, size[3]);
      for (int y = 0; y < target.height; ++y) {
        for (int x = 0; x < target.width; ++x) {
          for (int c = 0; c < channels; ++c) {
            const double exact = MeanOfParts(image, size[2], size[3], x, y, c);
            // Rounded to the nearest level; both sides are exact apart from double rounding.
            EXPECT_NEAR(target.At(x, y)[c], exact, 0.5 + 1e-9)
                << size[0] << "x" << size[1] << " -> " << size[2] << "x" << size[3] << " at " << x
                << "," << y << " channel " << c;
          }
        }
      }
    }
  }
}

TEST(ResizeByArea, HidesTheColourOfTransparentPixels) {
  Image image = MakeImage(2, 1, 4);
  const uint8_t pixels[] = {200, 100, 50, 255, 125, 125, 125, 0};
  image.pixels.assign(std::begin(pixels), std::end(pixels));
  const Image target = ResizeByArea(image, 1, 1);
  EXPECT_EQ(target.pixels, (std::vector<uint8_t>{200, 100, 50, 128}));
  image.pixels[3] = 0;
  EXPECT_EQ(ResizeByArea(image, 1, 1).pixels, (std::vector<uint8_t>{0, 0, 0, 0}));
}

TEST(ResizeByArea, KeepsAConstantImage) {
  Image image = MakeImage(37, 23, 3);
  image.pixels.assign(image.pixels.size(), 201);
  for (const int width : {1, 5, 36, 37, 50}) {
    for (const uint8_t value : ResizeByArea(image, width, 11).pixels) EXPECT_EQ(value, 201);
  }
}

TEST(ResizeByArea, OfTheSameSizeChangesNothing) {
  const Image image = RandomImage(6, 5, 3, 3);
  EXPECT_EQ(ResizeByArea(image, 6, 5).pixels, image.pixels);
}

TEST(ResizeSmoothly, IsTheAreaMeanOfWhatShrinksAndARampOfWhatGrows) {
  const Image image = RandomImage(9, 7, 4, 5);
  EXPECT_EQ(ResizeSmoothly(image, 4, 3).pixels, ResizeByArea(image, 4, 3).pixels);
  Image two = MakeImage(2, 1, 3);
  std::fill_n(two.At(1, 0), 3, uint8_t{200});
  const Image ramp = ResizeSmoothly(two, 8, 2);
  const int want[] = {0, 0, 25, 75, 125, 175, 200, 200};
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 2; ++y) EXPECT_EQ(ramp.At(x, y)[1], want[x]) << x;
  }
  // A transparent neighbour gives no colour.
  Image edge = MakeImage(2, 1, 4);
  const uint8_t pixels[] = {200, 100, 50, 255, 255, 255, 255, 0};
  edge.pixels.assign(std::begin(pixels), std::end(pixels));
  const Image wide = ResizeSmoothly(edge, 8, 1);
  EXPECT_EQ(wide.At(4, 0)[0], 200);
  EXPECT_EQ(wide.At(4, 0)[3], 96);
}

TEST(CompositeOver, MixesByAlpha) {
  Image image = MakeImage(3, 1, 4);
  const uint8_t pixels[] = {10, 20, 30, 0, 10, 20, 30, 255, 10, 20, 30, 51};
  image.pixels.assign(std::begin(pixels), std::end(pixels));
  const Image over = CompositeOver(image, 255, 0, 110);
  // alpha 51 is a fifth: 10 / 5 + 255 * 4 / 5 = 206.
  EXPECT_EQ(over.pixels, (std::vector<uint8_t>{255, 0, 110, 10, 20, 30, 206, 4, 94}));
}

TEST(ImageFiles, PngReturnsTheSameBytes) {
  const ScratchFolder folder;
  for (const int channels : {3, 4}) {
    const Image image = RandomImage(17, 9, channels, 5);
    WriteImage(folder / "a.png", image);
    const Image read = ReadImage(folder / "a.png");
    EXPECT_EQ(read.width, 17);
    EXPECT_EQ(read.height, 9);
    EXPECT_EQ(read.channels, channels);
    EXPECT_EQ(read.pixels, image.pixels);
  }
}

TEST(ImageFiles, JpegReturnsAboutTheSameColoursInTheSameOrder) {
  const ScratchFolder folder;
  const Image image = SmoothImage(64, 48);
  WriteImage(folder / "a.jpg", image);
  const Image read = ReadImage(folder / "a.jpg");
  ASSERT_EQ(read.pixels.size(), image.pixels.size());
  // A smooth image at JPEG quality 95; swapped channels would be off by up to 255.
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    EXPECT_NEAR(read.pixels[i], image.pixels[i], 12) << i;
  }
}

TEST(ImageFiles, JpegIsReadAsStoredDespiteItsExifRotation) {
  const std::vector<uint8_t> jpeg = SomeJpeg();
  const Image plain = DecodeImage(jpeg, "plain"),
              turned = DecodeImage(WithApp1(jpeg, kQuarterTurn), "turned");
  EXPECT_EQ(turned.width, 64);
  EXPECT_EQ(turned.height, 48);
  EXPECT_EQ(turned.pixels, plain.pixels);
}

TEST(ImageFiles, JpegIsTurnedByItsExifRotationOnRequest) {
  const std::vector<uint8_t> jpeg = SomeJpeg();
  const Image stored = DecodeImage(jpeg, "plain");
  const Image turned = DecodeImage(WithApp1(jpeg, kQuarterTurn), "turned", ExifRotation::kApply);
  ASSERT_EQ(turned.width, 48);
  ASSERT_EQ(turned.height, 64);
  // The first column of the stored image, read upwards, is the first row.
  for (int y = 0; y < turned.height; ++y) {
    for (int x = 0; x < turned.width; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_EQ(turned.At(x, y)[c], stored.At(y, 47 - x)[c]);
    }
  }
  EXPECT_EQ(DecodeImage(jpeg, "plain", ExifRotation::kApply).pixels, stored.pixels);
}

TEST(ImageFiles, SixteenBitsAreRoundedToTheNearestLevel) {
  cv::Mat deep(256, 256, CV_16UC1);
  for (int i = 0; i < 65536; ++i) deep.at<uint16_t>(i / 256, i % 256) = uint16_t(i);
  const Image image = DecodeImage(Encode(".png", deep), "deep");
  for (int i = 0; i < 65536; ++i) {
    ASSERT_EQ(image.At(i % 256, i / 256)[0], (i * 255 + 32767) / 65535) << i;
  }
  const cv::Mat rgba(1, 1, CV_16UC4, cv::Scalar(257 * 1, 257 * 2, 257 * 3, 257 * 4));
  EXPECT_EQ(DecodeImage(Encode(".png", rgba), "rgba").pixels, (std::vector<uint8_t>{3, 2, 1, 4}));
}

TEST(ImageFiles, GreyWithAlphaBecomesRgba) {
  const std::vector<uint8_t> png = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
      0x44, 0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x01, 0x08, 0x04, 0x00, 0x00,
      0x00, 0x5e, 0x2b, 0xb7, 0x01, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x44, 0x41, 0x54, 0x78,
      0x9c, 0x63, 0xf0, 0xfd, 0x7f, 0xc2, 0x18, 0x00, 0x05, 0xf9, 0x02, 0x48, 0x73, 0x9b,
      0xe8, 0xc6, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  EXPECT_EQ(DecodeImage(png, "grey").pixels,
            (std::vector<uint8_t>{77, 77, 77, 255, 200, 200, 200, 51}));
}

// An image of one row, pixel by pixel in OpenCV's order: blue, green, red, alpha.
std::vector<uint8_t> SomeExr(int channels, std::vector<float> values) {
  return Encode(".exr",
                cv::Mat(1, int(values.size()) / channels, CV_32FC(channels), values.data()));
}

// Linear light from display sRGB, by the inverse of the curve.
float Linear(double level) {
  const double v = level / 255;
  return float(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
}

TEST(ImageFiles, ExrReturnsTheLevelsThatItsLightCameFrom) {
  std::vector<float> grey, colour, premultiplied;
  std::vector<uint8_t> grey_levels, colour_levels, rgba_levels;
  for (int level = 0; level < 256; ++level) {
    const int other = 255 - level;
    grey.push_back(Linear(level));
    grey_levels.insert(grey_levels.end(), 3, uint8_t(level));
    colour.insert(colour.end(), {Linear(level), Linear(other), Linear(10)});
    colour_levels.insert(colour_levels.end(), {10, uint8_t(other), uint8_t(level)});
    const float alpha = float(level) / 255;
    premultiplied.insert(premultiplied.end(), {Linear(200) * alpha, Linear(255) * alpha, 0, alpha});
    const uint8_t seen = level > 0 ? 255 : 0;
    rgba_levels.insert(rgba_levels.end(), {0, seen, uint8_t(level > 0 ? 200 : 0), uint8_t(level)});
  }
  uint64_t clipped = 0;
  const auto decode = [&](const std::vector<uint8_t>& exr) {
    return DecodeImage(exr, "exr", ExifRotation::kIgnore, &clipped).pixels;
  };
  EXPECT_EQ(decode(SomeExr(1, grey)), grey_levels);
  EXPECT_EQ(decode(SomeExr(3, colour)), colour_levels);
  EXPECT_EQ(decode(SomeExr(4, premultiplied)), rgba_levels);
  EXPECT_EQ(clipped, 0u);
}

TEST(ImageFiles, ExrBeyondDisplayIsClippedAndCounted) {
  uint64_t clipped = 0;
  const std::vector<uint8_t> exr =
      SomeExr(3, {0, 0.2f, 1, 2, 0, 0, -1, 0, 0, NAN, 0, 1, 0, INFINITY, 0, 1.001f, 1, 1});
  const Image image = DecodeImage(exr, "bright", ExifRotation::kIgnore, &clipped);
  EXPECT_EQ(clipped, 4u);  // 1.001 is white within half a level
  EXPECT_EQ(image.pixels, (std::vector<uint8_t>{255, 124, 0, 0, 0, 255, 0, 0, 0, 255, 0, 0,  //
                                                0, 255, 0, 255, 255, 255}));
}

TEST(ImageFiles, AnExrCutAnywhereIsRefused) {
  cv::Mat mat(20, 20, CV_32FC3);
  cv::randu(mat, 0, 1);
  const std::vector<uint8_t> exr = Encode(".exr", mat);
  EXPECT_EQ(DecodeImage(exr, "whole").width, 20);
  for (size_t length = 0; length < exr.size(); length += 1 + length / 8)
    ExpectTruncated(exr, length);
  ExpectTruncated(exr, exr.size() - 1);
}

// The position at which an attribute's value starts.
size_t ExrValue(const std::vector<uint8_t>& exr, const std::string& name, const std::string& type) {
  const std::string attribute = name + '\0' + type + '\0';
  const auto found = std::search(exr.begin(), exr.end(), attribute.begin(), attribute.end());
  EXPECT_NE(found, exr.end());
  return size_t(found - exr.begin()) + attribute.size() + 4;
}

// A file of three channels with other one-letter names for B, G and R, in ascending order.
std::vector<uint8_t> WithChannels(std::vector<uint8_t> exr, const char (&names)[4]) {
  constexpr size_t kRecord = 18;  // a name, its end and 16 bytes
  const size_t channels = ExrValue(exr, "channels", "chlist");
  for (size_t i = 0; i < 3; ++i) exr[channels + i * kRecord] = uint8_t(names[i]);
  return exr;
}

TEST(ImageFiles, ExrOfGreyAndAlphaBecomesRgba) {
  const std::vector<float> values = {0.2f, 9, 0.2f * Linear(200), 0, 9, 0, 1, 9, Linear(77)};
  EXPECT_EQ(DecodeImage(WithChannels(SomeExr(3, values), "AXY"), "grey").pixels,
            (std::vector<uint8_t>{200, 200, 200, 51, 0, 0, 0, 0, 77, 77, 77, 255}));
}

TEST(ImageFiles, ExrsThatAreNotOnePlainImageAreRefused) {
  const std::vector<uint8_t> exr = SomeExr(3, std::vector<float>(12, 0.5f));
  const auto value_of = [&](const std::string& name, const std::string& type) {
    return ExrValue(exr, name, type);
  };
  using Changes = std::vector<std::pair<size_t, int>>;
  const auto message = [&](const Changes& changes, const char* part) {
    std::vector<uint8_t> bytes = exr;
    for (const auto& [position, value] : changes) bytes[position] = uint8_t(value);
    ExpectError<DataError>([&] { DecodeImage(bytes, "a.exr"); }, {"a.exr", part});
  };
  const size_t data = value_of("dataWindow", "box2i"), display = value_of("displayWindow", "box2i");
  const size_t ratio = value_of("pixelAspectRatio", "float");
  const size_t channels = value_of("channels", "chlist");
  message({{5, 0x08}}, "several parts or deep");
  message({{5, 0x10}}, "several parts or deep");
  message({{data + 8, 2}}, "store the whole image");
  message({{data + 10, 0x10}, {display + 10, 0x10}}, "image of 1048580 x 1 pixels");
  message({{data + 11, 0x80}, {display + 11, 0x80}}, "image of 0 x 1 pixels");
  message({{data + 9, 0xF0}, {data + 13, 1}, {display + 9, 0xF0}, {display + 13, 1}},
          "cannot contain the 15791108 bytes");  // 61,444 x 257
  message({{data - 16, 'X'}}, "header without a window");
  message({{data - 4, 15}}, "attribute dataWindow of 15 bytes; expected 16");
  message({{ratio - 1, 0x7F}}, "bytes of an EXR attribute do not fit");
  // OpenEXR itself reads past the end of a channel list that lacks its 0.
  message({{channels - 4, exr[channels - 4] - 1}}, "EXR channels");
  ExpectError<DataError>([&] { DecodeImage(WithChannels(exr, "AUZ"), "a.exr"); },
                         {"a.exr: EXR without a channel R, G, B or Y"});

  const auto refuse_attribute = [&](const std::string& name, const std::string& type,
                                    const std::string& value, const char* part) {
    const std::string attribute =
        name + '\0' + type + '\0' + char(value.size()) + std::string(3, '\0') + value;
    std::vector<uint8_t> bytes = exr;
    bytes.insert(bytes.begin() + 8, attribute.begin(), attribute.end());  // behind the flags
    ExpectError<DataError>([&] { DecodeImage(bytes, "a.exr"); }, {"a.exr", part});
  };
  refuse_attribute(std::string(256, 'n'), "int", "1234", "name that is too long");
  refuse_attribute("small", "preview", std::string("\2\0\0\0\3\0\0\0\0\0\0\0", 12),
                   "EXR preview: byte 8: 6 pixels do not fit in the remaining 4 bytes");
  refuse_attribute("words", "stringvector", std::string("\5\0\0\0word", 8),
                   "EXR texts: byte 4: 5 bytes of a text do not fit in the remaining 4 bytes");
}

// Found by fuzzing: OpenCV treated it as a DICOM file and believed a length of 1.9 GB.
TEST(ImageFiles, AnExrWithTheMarkOfADicomFileIsRefused) {
  std::vector<uint8_t> exr = SomeExr(3, std::vector<float>(12, 0.5f));
  ASSERT_GT(exr.size(), 132u);
  const std::string mark = "DICM";
  std::copy(mark.begin(), mark.end(), exr.begin() + 128);
  ExpectError<DataError>([&] { DecodeImage(exr, "a.exr"); },
                         {"a.exr: EXR with the mark of a DICOM file at byte 128"});
}

TEST(ImageFiles, WithoutSpaceForATemporaryFileAnExrIsNotCalledDamaged) {
  const std::vector<uint8_t> exr = SomeExr(3, std::vector<float>(12, 0.5f));
  const ScratchFolder folder;
  setenv("OPENCV_TEMP_PATH", folder.path().c_str(), 1);
  const std::string message = MessageOf<EnvironmentError>([&] {
    const FileSizeLimit limit(16);
    DecodeImage(exr, "a.exr");
  });
  unsetenv("OPENCV_TEMP_PATH");
  EXPECT_THAT(message, ::testing::HasSubstr("a.exr: cannot be decoded: "));
  EXPECT_THAT(message, ::testing::HasSubstr("temporary file"));
}

// The file with one more attribute in front: eight numbers. Its one block of pixels moves.
std::vector<uint8_t> WithChromaticities(const std::vector<uint8_t>& exr,
                                        const std::array<float, 8>& values) {
  std::string attribute("chromaticities\0chromaticities\0\x20\0\0\0", 34);
  attribute.append(reinterpret_cast<const char*>(values.data()), sizeof(values));
  std::vector<uint8_t> bytes = exr;
  // The table of blocks is in front of the block and contains its position.
  for (size_t i = 0; i + 8 <= bytes.size(); ++i) {
    uint64_t place = 0;
    std::memcpy(&place, &bytes[i], sizeof(place));
    if (place != i + 8) continue;
    place += attribute.size();
    std::memcpy(&bytes[i], &place, sizeof(place));
    bytes.insert(bytes.begin() + 8, attribute.begin(), attribute.end());
    return bytes;
  }
  ADD_FAILURE() << "no table of blocks";
  return bytes;
}

TEST(ImageFiles, ExrOfOtherPrimariesThanRec709IsRefused) {
  const std::vector<uint8_t> exr = SomeExr(3, {0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f});
  using Values = std::array<float, 8>;
  const Values rec709 = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
  EXPECT_EQ(DecodeImage(WithChromaticities(exr, rec709), "a.exr").pixels,
            DecodeImage(exr, "a.exr").pixels);
  Values rounded = rec709;
  rounded[6] = 0.313f;
  EXPECT_EQ(DecodeImage(WithChromaticities(exr, rounded), "a.exr").width, 2);

  const auto refused = [&](const Values& values, const char* part) {
    ExpectError<DataError>(
        [&] { DecodeImage(WithChromaticities(exr, values), "a.exr"); },
        {"a.exr: EXR with chromaticities", part, "convert it to linear Rec. 709 (sRGB primaries)"});
  };
  refused({0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f},  // ACES 2065-1
          "red (0.7347, 0.2653), green (0, 1), blue (0.0001, -0.077), white (0.32168, 0.33767)");
  for (size_t i = 0; i < 8; ++i) {
    Values other = rec709;
    other[i] += 0.002f;
    refused(other, fmt::format("{}", other[i]).c_str());
    other[i] = NAN;
    refused(other, "nan");
  }
}

TEST(MaskedBy, MultipliesAlphaByTheMask) {
  Image rgb = MakeImage(3, 1, 3);
  rgb.pixels = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  Image mask = rgb;
  mask.pixels = {255, 255, 255, 0, 0, 0, 0, 51, 20};  // the largest channel counts
  EXPECT_EQ(MaskedBy(rgb, mask).pixels,
            (std::vector<uint8_t>{1, 2, 3, 255, 4, 5, 6, 0, 7, 8, 9, 51}));
  Image rgba = MakeImage(1, 1, 4), half = MakeImage(1, 1, 4);
  rgba.pixels = {1, 2, 3, 100};
  half.pixels = {255, 255, 255, 128};
  EXPECT_EQ(MaskedBy(rgba, half).pixels, (std::vector<uint8_t>{1, 2, 3, 50}));
}

TEST(MaskedBy, AcceptsMasksOfZeroAndOneAndOfOtherSizes) {
  Image rgb = MakeImage(4, 2, 3), bits = MakeImage(4, 2, 3), small = MakeImage(2, 1, 3);
  rgb.pixels.assign(rgb.pixels.size(), 9);
  const auto alpha = [&](const Image& mask) { return AlphaOf(MaskedBy(rgb, mask)); };
  std::fill_n(bits.At(0, 1), 6, uint8_t(1));
  EXPECT_EQ(alpha(bits), (std::vector<uint8_t>{0, 0, 0, 0, 255, 255, 0, 0}));
  std::fill_n(small.At(1, 0), 3, uint8_t(1));
  EXPECT_EQ(alpha(small), (std::vector<uint8_t>{0, 0, 255, 255, 0, 0, 255, 255}));
  Image large = MakeImage(8, 4, 3);
  std::fill_n(large.At(0, 0), 3 * 4, uint8_t(200));  // half of two pixels
  EXPECT_EQ(alpha(large), (std::vector<uint8_t>{100, 100, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(alpha(MakeImage(4, 2, 3)), std::vector<uint8_t>(8, 0));
}

TEST(ImageFiles, SixteenBitsGreyAndPaletteBecomeEightBitColours) {
  const cv::Mat deep(1, 3, CV_16UC3, cv::Scalar(65535, 257 * 100 + 100, 0));  // blue, green, red
  const Image image = DecodeImage(Encode(".png", deep), "deep");
  EXPECT_EQ(image.pixels, (std::vector<uint8_t>{0, 100, 255, 0, 100, 255, 0, 100, 255}));

  const cv::Mat grey(2, 1, CV_8UC1, cv::Scalar(77));
  EXPECT_EQ(DecodeImage(Encode(".png", grey), "grey").pixels, std::vector<uint8_t>(6, 77));

  // 2 x 2 pixels of a palette: red, green with alpha 128, blue, white.
  const std::vector<uint8_t> palette = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
      0x44, 0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x08, 0x03, 0x00, 0x00,
      0x00, 0x45, 0x68, 0xfd, 0x16, 0x00, 0x00, 0x00, 0x0c, 0x50, 0x4c, 0x54, 0x45, 0xff,
      0x00, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00, 0xff, 0xff, 0xff, 0xff, 0xfb, 0x00, 0x60,
      0xf6, 0x00, 0x00, 0x00, 0x02, 0x74, 0x52, 0x4e, 0x53, 0xff, 0x80, 0x08, 0x0f, 0xb3,
      0x6a, 0x00, 0x00, 0x00, 0x0e, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x60, 0x60,
      0x64, 0x60, 0x62, 0x06, 0x00, 0x00, 0x11, 0x00, 0x07, 0x9e, 0xa2, 0x2a, 0x12, 0x00,
      0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  const Image colours = DecodeImage(palette, "palette");
  ASSERT_EQ(colours.channels, 4);
  EXPECT_EQ(colours.pixels, (std::vector<uint8_t>{255, 0, 0, 255, 0, 255, 0, 128,  //
                                                  0, 0, 255, 255, 255, 255, 255, 255}));
}

TEST(ImageFiles, APngCutAnywhereIsRefused) {
  cv::Mat mat(40, 40, CV_8UC4);
  cv::randu(mat, 0, 255);
  const std::vector<uint8_t> png = Encode(".png", mat);
  for (size_t length = 0; length < png.size(); length += 1 + length / 8)
    ExpectTruncated(png, length);
  ExpectTruncated(png, png.size() - 1,
                  "truncated image, ends after " + std::to_string(png.size() - 1) + " bytes");
}

TEST(ImageFiles, AJpegCutAnywhereIsRefused) {
  // The end of a thumbnail inside must not be taken for the end of the image.
  const std::vector<uint8_t> thumbnail = {0xFF, 0xD8, 0xFF, 0xD9};
  for (const int progressive : {0, 1}) {
    const std::vector<uint8_t> jpeg =
        WithApp1(SomeJpeg({cv::IMWRITE_JPEG_PROGRESSIVE, progressive}), thumbnail);
    EXPECT_EQ(DecodeImage(jpeg, "whole").width, 64);
    for (size_t length = 0; length < jpeg.size(); length += 1 + length / 8) {
      ExpectTruncated(jpeg, length);
    }
    ExpectTruncated(jpeg, jpeg.size() - 1, "truncated image, ends after");
  }
}

// A part of the scans was lost, was overwritten, or misses a single bit.
TEST(ImageFiles, AJpegDamagedInItsMiddleIsRefused) {
  for (const int progressive : {0, 1}) {
    const std::vector<uint8_t> jpeg = SomeJpeg({cv::IMWRITE_JPEG_PROGRESSIVE, progressive});
    const auto middle = jpeg.begin() + std::ptrdiff_t(jpeg.size() / 2);
    std::vector<uint8_t> shorter(jpeg.begin(), middle);
    shorter.insert(shorter.end(), middle + 200, jpeg.end());
    std::vector<uint8_t> zeroed = jpeg;
    std::fill_n(zeroed.begin() + (middle - jpeg.begin()), 1000, uint8_t(0));
    for (const auto& damaged : {shorter, zeroed}) {
      ExpectError<DataError>([&] { DecodeImage(damaged, "a.jpg"); },
                             {"a.jpg", "damaged image (", "copy it again or remove it"});
    }
  }
}

// Cameras write such files, and nothing of the image is lost.
TEST(ImageFiles, OddBytesInTheHeaderOfAJpegDoNotMatter) {
  std::vector<uint8_t> jpeg = SomeJpeg();
  const Image image = DecodeImage(jpeg, "plain");
  constexpr int kBehindJfif = 20;
  jpeg.insert(jpeg.begin() + kBehindJfif, 5, uint8_t(0x11));
  EXPECT_EQ(DecodeImage(jpeg, "odd").pixels, image.pixels);
}

TEST(ImageFiles, PaddingBehindTheScansOfAJpegDoesNotMatter) {
  std::vector<uint8_t> jpeg = SomeJpeg();
  const Image image = DecodeImage(jpeg, "plain");
  jpeg.insert(jpeg.end() - 2, 16, uint8_t(0));
  EXPECT_EQ(DecodeImage(jpeg, "padded").pixels, image.pixels);
}

TEST(ImageFiles, AJpegOfEndlessScansIsRefused) {
  std::vector<uint8_t> jpeg = SomeJpeg();
  const std::vector<uint8_t> scan = {0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 0, 0};
  for (int i = 0; i < 600; ++i) jpeg.insert(jpeg.end() - 2, scan.begin(), scan.end());
  ExpectError<DataError>([&] { DecodeImage(jpeg, "a.jpg"); }, {"a.jpg", "601 scans"});
}

TEST(ImageFiles, BytesBehindTheEndOfAJpegDoNotMatter) {
  std::vector<uint8_t> jpeg = SomeJpeg();
  const Image image = DecodeImage(jpeg, "plain");
  jpeg.insert(jpeg.end(), 100, 0xAB);
  EXPECT_EQ(DecodeImage(jpeg, "trailer").pixels, image.pixels);
}

TEST(ImageFiles, OtherThingsAreRefusedWithTheirName) {
  const ScratchFolder folder;
  ExpectError<DataError>([&] { ReadImage(folder / "none.png"); }, {"none.png"});
  ExpectError<DataError>([&] { ReadImage(folder.Write("e.png", "")); }, {"e.png", "empty"});
  ExpectError<DataError>([&] { ReadImage(folder.Write("t.png", "not an image at all")); },
                         {"t.png", "not an image"});
  const cv::Mat some(4, 4, CV_8UC3, cv::Scalar(5, 5, 5));
  ExpectError<DataError>([&] { DecodeImage(Encode(".bmp", some), "a.bmp"); },
                         {"a.bmp", "expected PNG, JPEG, TIFF or EXR"});
  std::vector<uint8_t> damaged = Encode(".png", some);
  damaged[45] ^= 0xFF;  // inside the pixels' chunk
  ExpectError<DataError>([&] { DecodeImage(damaged, "d.png"); }, {"d.png: damaged image"});
  std::vector<uint8_t> headless = Encode(".png", some);
  headless[12] = 'X';  // in place of the I of IHDR
  ExpectError<DataError>([&] { DecodeImage(headless, "h.png"); },
                         {"h.png: PNG file without a header chunk"});
  const std::filesystem::path large = folder.Write("l.png", "");
  std::filesystem::resize_file(large, uint64_t{1} << 31);  // needs no space
  ExpectError<DataError>([&] { ReadImage(large); },
                         {"l.png: has 2,147,483,648 bytes; at most 2,147,483,647 are read"});
}

TEST(ImageFiles, AHugeImageIsRefusedBeforeItIsDecoded) {
  std::vector<uint8_t> png = Encode(".png", cv::Mat(2, 2, CV_8UC3, cv::Scalar(0)));
  std::vector<uint8_t> claims = png;
  claims[17] = 0x01, claims[19] = 0x00, claims[22] = 0x0F;  // 65,536 x 3,842
  ExpectError<DataError>([&] { DecodeImage(claims, "claims"); },
                         {"claims: a file of", "cannot contain the 755367936 bytes"});
  png[16] = 0x00, png[17] = 0x01, png[18] = 0x86, png[19] = 0xA0;  // 100,000 wide
  ExpectError<DataError>([&] { DecodeImage(png, "wide"); }, {"wide", "100000 x 2"});
}

}  // namespace
}  // namespace tetrec
