#include "surface/texture_bake.h"

#include "core/error.h"
#include "expect_error.h"
#include "surface/texels.h"
#include "surface/texture.h"
#include "surface/textured_shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

struct TexelError {
  double texture = 0, vertex_colors = 0;  // mean over texels inside triangles, of 0 to 1
  double worst = 0;                       // of the texture
};

TexelError ErrorOf(const TriangleMesh& mesh, const TextureLayout& layout, const Image& image,
                   const Paint& paint) {
  TexelError error;
  double count = 0;
  const Texels texels = FindTexels(layout);
  for (int y = 0; y < layout.size; ++y) {
    for (int x = 0; x < layout.size; ++x) {
      const uint32_t t = texels.triangle[size_t(y) * size_t(layout.size) + size_t(x)];
      if (t == kNoTriangle) continue;
      const glm::dvec3 weights = NearestWeights(layout.corners[t], {x + 0.5, y + 0.5});
      glm::dvec3 point(0.0);
      for (int k = 0; k < 3; ++k) {
        point += weights[k] * glm::dvec3(mesh.positions[mesh.triangles[t][k]]);
      }
      const glm::dvec3 truth = paint(point);
      double off = 0, plain = 0;
      for (int c = 0; c < 3; ++c) {
        off += std::abs(image.At(x, y)[c] / 255.0 - truth[c]) / 3;
        plain += std::abs(128 / 255.0 - truth[c]) / 3;
      }
      error.texture += off;
      error.vertex_colors += plain;
      error.worst = std::max(error.worst, off);
      ++count;
    }
  }
  error.texture /= count;
  error.vertex_colors /= count;
  return error;
}

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

// A wall and, in front of a part of it, a plate.
TriangleMesh WallBehindPlate() {
  TriangleMesh mesh;
  mesh.positions = {{-1, -1, 0},       {1, -1, 0},       {1, 1, 0},       {-1, 1, 0},
                    {-0.5f, -0.5f, 1}, {0.5f, -0.5f, 1}, {0.5f, 0.5f, 1}, {-0.5f, 0.5f, 1}};
  mesh.colors_srgb.assign(8, {128, 128, 128});
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 5, 6}, {4, 6, 7}};
  return mesh;
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
  const BakedTexture baked =
      BakeTexture(cube, LayOutTextureOfSize(cube, CutIntoCharts(cube), 64), {});
  EXPECT_EQ(baked.seen_share, 0);
  for (const uint8_t level : baked.image.pixels) ASSERT_EQ(level, 128);
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
