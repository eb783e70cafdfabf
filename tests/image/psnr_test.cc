#include "image/psnr.h"

#include "core/error.h"
#include "expect_error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

Image Constant(int width, int height, uint8_t value) {
  return {width, height, 3, std::vector<uint8_t>(size_t(width) * height * 3, value)};
}

TEST(Psnr, EqualImagesHaveNoErrorAndInfinitePsnrWhichTheCapMakesFinite) {
  const Image image = Constant(31, 17, 99);
  EXPECT_EQ(MeanSquaredError(image, image), 0);
  EXPECT_TRUE(std::isinf(PsnrFromMse(0)));
  EXPECT_EQ(CappedPsnrFromMse(0), 100);
  EXPECT_EQ(CappedPsnrFromMse(1e-11), 100);
  EXPECT_EQ(CappedPsnrFromMse(1e-3), PsnrFromMse(1e-3));
}

TEST(Psnr, AConstantOffsetGivesThePsnrOfThatOffset) {
  for (const int offset : {1, 16, 255}) {
    const double mse = MeanSquaredError(Constant(8, 5, uint8_t(offset)), Constant(8, 5, 0));
    EXPECT_DOUBLE_EQ(PsnrFromMse(mse), 20 * std::log10(255.0 / offset)) << offset;
  }
}

TEST(Psnr, AlphaDoesNotCount) {
  Image rgb{6, 4, 3, {}};
  for (int i = 0; i < 72; ++i) rgb.pixels.push_back(uint8_t(37 * i));
  Image rgba{6, 4, 4, {}};
  for (size_t i = 0; i < 24; ++i) {
    rgba.pixels.insert(rgba.pixels.end(), {rgb.pixels[3 * i], rgb.pixels[3 * i + 1],
                                           rgb.pixels[3 * i + 2], uint8_t(i)});
  }
  EXPECT_EQ(MeanSquaredError(rgba, rgb), 0);
}

TEST(Psnr, ForegroundErrorSeesOnlyTheMask) {
  Image truth = Constant(4, 2, 50), render = truth, mask = Constant(4, 2, 0);
  for (int y = 0; y < 2; ++y) {
    for (int c = 0; c < 3; ++c) {
      render.At(0, y)[c] = 60;   // inside
      render.At(3, y)[c] = 255;  // outside
      mask.At(0, y)[c] = 128;
      mask.At(1, y)[c] = 255;
      mask.At(2, y)[c] = 127;
    }
  }
  EXPECT_DOUBLE_EQ(MaskedMeanSquaredError(render, truth, mask).value(),
                   0.5 * 100 / (255.0 * 255.0));
  EXPECT_FALSE(MaskedMeanSquaredError(render, truth, Constant(4, 2, 0)).has_value());
}

TEST(Psnr, ImagesAndMasksOfAnotherSizeAreRefused) {
  const Image image = Constant(4, 2, 0), turned = Constant(2, 4, 0);
  ExpectError<DataError>([&] { MeanSquaredError(image, turned); }, {"4x2", "2x4", "ground truth"});
  ExpectError<DataError>([&] { MaskedMeanSquaredError(image, turned, image); },
                         {"4x2", "2x4", "ground truth"});
  ExpectError<DataError>([&] { MaskedMeanSquaredError(image, image, turned); },
                         {"4x2", "2x4", "mask"});
}

}  // namespace
}  // namespace tetrec
