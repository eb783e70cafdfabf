// What stored images ask of pictures.
#include "render/target_image.h"

#include <gtest/gtest.h>

#include <vector>

namespace tetrec {
namespace {

// Pixels of one colour whose alpha is 255, 200, kSeenAlpha, 1 less, and 0.
Image FadingOut() {
  Image image = MakeImage(5, 1, 4);
  image.pixels = {200, 100, 50, 255, 200, 100, 50, 200,
                  200, 100, 50, 128, 200, 100, 50, kSeenAlpha - 1,
                  200, 100, 50, 0};
  return image;
}

TEST(TruthOf, PixelsThatCountAreAsStoredHoweverSoftTheirMask) {
  const Image truth = TruthOf(FadingOut(), true, Background::kScene);
  EXPECT_EQ(truth.pixels, (std::vector<uint8_t>{200, 100, 50, 200, 100, 50, 200, 100, 50,  //
                                                100, 50, 25, 0, 0, 0}));
}

TEST(TruthOf, OpacityIsSeenOverTheBackground) {
  const Image truth = TruthOf(FadingOut(), false, Background::kWhite);
  EXPECT_EQ(truth.pixels, (std::vector<uint8_t>{200, 100, 50, 212, 133, 94, 227, 177, 152,  //
                                                228, 178, 153, 255, 255, 255}));
}

// The pixels that are judged have the colours that training asks for.
TEST(TruthOf, HasTheColoursOfTheTarget) {
  const Image stored = FadingOut();
  const Image truth = TruthOf(stored, true, Background::kScene);
  const TargetImage target = TargetOf(stored, true);
  for (int x = 0; x < stored.width; ++x) {
    const uint32_t wanted = target.rgba8[size_t(x)];
    if (wanted == kNotJudgedTarget) continue;
    for (int c = 0; c < 3; ++c) EXPECT_EQ(truth.At(x, 0)[c], wanted >> (8 * c) & 255) << x;
  }
}

TEST(TruthOf, ImagesWithoutAlphaStay) {
  Image image = MakeImage(2, 1, 3);
  image.pixels = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(TruthOf(image, true, Background::kWhite).pixels, image.pixels);
}

}  // namespace
}  // namespace tetrec
