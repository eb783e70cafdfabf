#include "eval/image_metrics.h"

#include "core/error.h"
#include "eval/fake_run.h"
#include "expect_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

Image Constant(int width, int height, uint8_t value) {
  return {width, height, 3, std::vector<uint8_t>(size_t(width) * height * 3, value)};
}

// SSIM by its definition: for each pixel the whole 2-d window, in two passes (means, then central
// moments), pixels outside being 0. Shares no code with the product.
double SsimByDefinition(const Image& a, const Image& b) {
  double window[11][11], total = 0;
  for (int j = -5; j <= 5; ++j) {
    for (int i = -5; i <= 5; ++i) {
      total += window[j + 5][i + 5] = std::exp(-(i * i + j * j) / (2 * 1.5 * 1.5));
    }
  }
  const auto value = [](const Image& image, int x, int y, int c) {
    const bool inside = x >= 0 && y >= 0 && x < image.width && y < image.height;
    return inside ? image.At(x, y)[c] / 255.0 : 0.0;
  };
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    for (int y = 0; y < a.height; ++y) {
      for (int x = 0; x < a.width; ++x) {
        double ma = 0, mb = 0, vaa = 0, vbb = 0, vab = 0;
        const auto each = [&](auto add) {
          for (int j = -5; j <= 5; ++j) {
            for (int i = -5; i <= 5; ++i) {
              add(window[j + 5][i + 5] / total, value(a, x + i, y + j, c),
                  value(b, x + i, y + j, c));
            }
          }
        };
        each([&](double w, double p, double q) { ma += w * p, mb += w * q; });
        each([&](double w, double p, double q) {
          vaa += w * (p - ma) * (p - ma), vbb += w * (q - mb) * (q - mb),
              vab += w * (p - ma) * (q - mb);
        });
        sum += (2 * ma * mb + 1e-4) * (2 * vab + 9e-4) /
               ((ma * ma + mb * mb + 1e-4) * (vaa + vbb + 9e-4));
      }
    }
  }
  return sum / (3.0 * a.width * a.height);
}

TEST(ImageMetrics, EqualImagesHaveSsimOne) {
  const Image picture = TestPicture(31, 17, 0);
  EXPECT_NEAR(Ssim(picture, picture), 1, 1e-12);  // rounding of the window sums
}

TEST(ImageMetrics, SsimAgreesWithItsDefinitionAtEveryKindOfBorder) {
  // Both sum in double; the product takes variances as differences of means, which costs about
  // 1e-16 / C2 = 1e-13.
  for (const auto& [width, height] :
       {std::pair(23, 19), std::pair(11, 11), std::pair(4, 3), std::pair(1, 1)}) {
    const Image truth = TestPicture(width, height, 2), render = Disturbed(truth, 40);
    EXPECT_NEAR(Ssim(render, truth), SsimByDefinition(render, truth), 1e-11)
        << width << "x" << height;
  }
}

TEST(ImageMetrics, SsimOfTwoConstantsInTheMiddleIsTheLuminanceTermAlone) {
  // Far from the border (window radius 5) variances vanish; the picture is wide enough that the
  // border's share is known to be the rest, so compare two sizes instead: their inner pixels differ
  // only in number.
  const auto sum = [](int size) {
    return Ssim(Constant(size, size, 100), Constant(size, size, 120)) * size * size;
  };
  const double a = 100 / 255.0, b = 120 / 255.0;
  const double inner = (2 * a * b + 1e-4) / (a * a + b * b + 1e-4);
  // S(n) = corners + n * edges + n^2 * inner, so the second difference is 2 * inner.
  EXPECT_NEAR((sum(42) - 2 * sum(41) + sum(40)) / 2, inner, 1e-9);
}

TEST(ImageMetrics, MaskedSsimKnowsNothingOfWhatIsHidden) {
  Image truth = Constant(40, 30, 100), render = truth, mask = Constant(40, 30, 255);
  for (int y = 0; y < 30; ++y) {
    for (int x = 0; x < 40; ++x) {
      for (int c = 0; c < 3; ++c) {
        truth.At(x, y)[c] = uint8_t(3 * x + 40 * c + y * y % 50);
        render.At(x, y)[c] = uint8_t(truth.At(x, y)[c] + (x * y + c) % 30);
        if (x >= 25) mask.At(x, y)[c] = 127;
      }
    }
  }
  EXPECT_NEAR(MaskedSsim(render, truth, Constant(40, 30, 128)).value(), Ssim(render, truth), 1e-12);
  const double with_all = MaskedSsim(render, truth, mask).value();
  EXPECT_LT(with_all, 0.99);
  for (int y = 0; y < 30; ++y) {
    for (int x = 25; x < 40; ++x) render.At(x, y)[0] = uint8_t(17 * x * y);
  }
  EXPECT_EQ(MaskedSsim(render, truth, mask).value(), with_all);
  EXPECT_FALSE(MaskedSsim(render, truth, Constant(40, 30, 0)).has_value());
  ExpectError<DataError>([&] { MaskedSsim(render, truth, Constant(30, 40, 0)); },
                         {"40x30", "30x40"});
}

TEST(ImageMetrics, PicturesOfDifferentSizesAreRefused) {
  ExpectError<DataError>([] { Ssim(Constant(4, 2, 0), Constant(4, 3, 0)); }, {"4x2", "4x3"});
}

TEST(ImageMetrics, TheErrorMapIsDarkWhereEqualAndSaturatesAtAQuarterOfTheRange) {
  const Image black = Constant(1, 1, 0);
  const auto brightness = [&](uint8_t error) {
    const Image map = ErrorMap(Constant(1, 1, error), black);
    return map.pixels[0] + map.pixels[1] + map.pixels[2];
  };
  EXPECT_LT(brightness(0), 10);
  EXPECT_LT(brightness(0), brightness(20));
  EXPECT_LT(brightness(20), brightness(60));
  EXPECT_EQ(brightness(64), brightness(255));
}

TEST(ContrastTest, IsTheDeviationOfTheBrightness) {
  Image image = MakeImage(2, 1, 3);
  std::fill_n(image.pixels.begin(), 6, uint8_t{200});
  EXPECT_EQ(Contrast(image), 0);
  // Brightness 100 and 200: 50 from their mean.
  image.pixels = {0, 100, 200, 200, 200, 200};
  EXPECT_NEAR(Contrast(image), 50, 1e-9);
  Image mask = MakeImage(2, 1, 3);
  mask.pixels = {255, 255, 255, 0, 0, 0};
  EXPECT_NEAR(Contrast(image, &mask), 0, 1e-4);
}

}  // namespace
}  // namespace tetrec
