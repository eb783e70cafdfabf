#include "surface/texture_bake.h"

#include "core/error.h"
#include "expect_error.h"
#include "surface/texels.h"
#include "surface/texture.h"
#include "surface/texture_error.h"
#include "surface/textured_shapes.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TEST(BakeTexture, ATexturedCubeHasTheColoursOfItsPaintWhateverThePhotosExposure) {
  const TriangleMesh cube = GreyCube();
  const std::vector<TexturePhoto> photos = PhotosAround(cube, Waves);
  const TextureLayout layout =
      LayOutTexture(cube, CutIntoCharts(cube), MedianFootprint(cube, photos), 1024);
  const BakedTexture baked = BakeTexture(cube, layout, photos);
  const TexelError error = ErrorOf(cube, layout, baked.image, Waves);
  EXPECT_GT(error.vertex_colors, 0.2);
  EXPECT_LT(error.texture, 0.02);  // interpolation and 8 bits
  EXPECT_LT(error.worst, 0.3);
  EXPECT_GT(baked.seen_share, 0.95);
}

TEST(BakeTexture, WhatNoPhotoSeesHasTheVertexColoursAndNotWhatIsInFrontOfIt) {
  const TriangleMesh mesh = WallBehindPlate();
  const Paint paint = [](const glm::dvec3& p) {
    return p.z > 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  };
  const std::vector<TexturePhoto> photos = {PhotoOf(mesh, paint, {0, 0, 4})};
  const TextureLayout layout = LayOutTextureOfSize(mesh, CutIntoCharts(mesh), 256);
  const BakedTexture baked = BakeTexture(mesh, layout, photos);
  const Texels texels = FindTexels(layout);
  int hidden = 0, open = 0;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      const uint32_t t = texels.triangle[size_t(y) * 256 + size_t(x)];
      if (t > 1) continue;  // the plate, or nothing
      const glm::dvec3 weights = NearestWeights(layout.corners[t], {x + 0.5, y + 0.5});
      glm::dvec3 point(0.0);
      for (int k = 0; k < 3; ++k) {
        point += weights[k] * glm::dvec3(mesh.positions[mesh.triangles[t][k]]);
      }
      const double reach = std::max(std::abs(point.x), std::abs(point.y));
      const uint8_t* rgb = baked.image.At(x, y);
      ASSERT_LE(rgb[0], 140) << "red of the plate at " << point.x << ", " << point.y;
      if (reach < 0.6) {  // its shadow, seen from the camera, reaches to 0.5 * 4 / 3
        ++hidden;
        EXPECT_EQ(rgb[1], 128);
      } else if (reach > 0.75 && reach < 0.9) {
        ++open;
        EXPECT_GT(rgb[1], 250);
      }
    }
  }
  EXPECT_GT(hidden, 1000);
  EXPECT_GT(open, 1000);
}

TEST(BakeTexture, WithoutPhotosEverythingHasTheVertexColours) {
  const TriangleMesh cube = GreyCube();
  EXPECT_EQ(MedianFootprint(cube, {}), 0);
  const TextureLayout layout = LayOutTextureOfSize(cube, CutIntoCharts(cube), 64);
  const BakedTexture baked = BakeTexture(cube, layout, {});
  EXPECT_EQ(baked.seen_share, 0);
  const Texels texels = FindTexels(layout);
  for (size_t i = 0; i < texels.triangle.size(); ++i) {
    if (texels.triangle[i] == kNoTriangle) continue;
    ASSERT_EQ(baked.image.pixels[3 * i], 128);
  }
}

TEST(TextureChoice, IsAWordOrASize) {
  EXPECT_TRUE(ParseTextureChoice("auto").wanted);
  EXPECT_FALSE(ParseTextureChoice("off").wanted);
  EXPECT_EQ(ParseTextureChoice("2048").size, 2048);
  for (const char* text : {"", "on", "63", "8193", "-1024", "1024x1024", "99999999999"}) {
    ExpectError<UsageError>([&] { ParseTextureChoice(text); }, {"expected auto, off"});
  }
}

}  // namespace
}  // namespace tetrec
