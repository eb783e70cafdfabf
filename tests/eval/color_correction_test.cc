#include "eval/color_correction.h"

#include "core/error.h"
#include "eval/fake_run.h"
#include "image/psnr.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

constexpr int kWidth = 41, kHeight = 30;

// What TestPicture shows with other gains and offsets.
Image Exposed(const Image& image, double gain, double offset) {
  const GainOffset channel{gain, offset};
  return WithColors(image, {channel, channel, channel});
}

TEST(ColorCorrection, OfAPictureWithOtherExposureRemovesAllButRounding) {
  const Image truth = TestPicture(kWidth, kHeight, 0), render = Exposed(truth, 0.7, 0.05);
  const HalfScores scores = ScoreHalves(render, truth, nullptr).value();
  EXPECT_GT(scores.raw_mse, 1e-3);
  // Rounding the render and the corrected picture to 8 bits: 1/12 of a step squared, twice.
  EXPECT_LT(scores.corrected_mse, 6e-6);
}

// The right half of the render is another picture: what was fitted on the left must not help there.
TEST(ColorCorrection, DoesNotSeeTheHalfThatItIsJudgedBy) {
  const Image truth = TestPicture(kWidth, kHeight, 0);
  Image render = truth;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = kWidth / 2; x < kWidth; ++x) {
      for (int c = 0; c < 3; ++c) render.At(x, y)[c] = uint8_t(render.At(x, y)[c] / 2);
    }
  }
  const HalfScores scores = ScoreHalves(render, truth, nullptr).value();
  EXPECT_EQ(scores.corrected_mse, scores.raw_mse);
  EXPECT_NEAR(scores.raw_mse * double(kWidth - kWidth / 2) / kWidth,
              MeanSquaredError(render, truth), 1e-12);
}

TEST(ColorCorrection, IsFittedOnlyWhereTheMaskSelects) {
  const Image truth = TestPicture(kWidth, kHeight, 0);
  Image render = Exposed(truth, 0.8, 0.1), mask = MakeImage(kWidth, kHeight, 3);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const bool selected = y >= 10;
      for (int c = 0; c < 3; ++c) {
        mask.At(x, y)[c] = selected ? 255 : 0;
        if (!selected) render.At(x, y)[c] = uint8_t((x * 37 + y * 11) % 256);
      }
    }
  }
  EXPECT_LT(ScoreHalves(render, truth, &mask)->corrected_mse, 6e-6);
  EXPECT_GT(ScoreHalves(render, truth, nullptr)->corrected_mse, 1e-3);
}

TEST(ColorCorrection, OfAFlatHalfIsTheOffset) {
  Image truth = MakeImage(8, 8, 3), render = truth;
  for (uint8_t& value : truth.pixels) value = 120;
  for (uint8_t& value : render.pixels) value = 100;
  EXPECT_EQ(ScoreHalves(render, truth, nullptr)->corrected_mse, 0);
}

TEST(ColorCorrection, OfHalvesWithoutPixelsIsUnknown) {
  const Image one_column = TestPicture(1, 8, 0);
  EXPECT_FALSE(ScoreHalves(one_column, one_column, nullptr));
  const Image picture = TestPicture(8, 8, 0);
  for (const bool left_is_empty : {false, true}) {
    Image mask = MakeImage(8, 8, 3);
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 4; ++x) mask.At(left_is_empty ? x + 4 : x, y)[0] = 255;
    }
    EXPECT_FALSE(ScoreHalves(picture, picture, &mask));
  }
  EXPECT_THROW(ScoreHalves(picture, one_column, nullptr), DataError);
}

}  // namespace
}  // namespace tetrec
