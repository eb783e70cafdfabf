// Depth maps: their files, and the images that show them.
#include "image/depth_map.h"

#include "core/error.h"
#include "expect_error.h"
#include "image/plane_depth.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

TEST(DepthMap, AFileGivesTheSameBitsAgain) {
  const ScratchFolder folder;
  DepthMap map = PlaneDepth({0.1, 0.2, 1}, 3);
  map.At(3, 4) = kNoDepth;
  map.At(5, 6) = 1e9f;
  WriteDepthMap(folder / "a.exr", map);
  const DepthMap read = ReadDepthMap(folder / "a.exr");
  EXPECT_EQ(read.width, map.width);
  EXPECT_EQ(read.height, map.height);
  EXPECT_EQ(read.depth, map.depth);
}

TEST(DepthMap, WhatIsNoDepthMapIsRefused) {
  const ScratchFolder folder;
  WriteImage(folder / "a.png", MakeImage(4, 4, 3));
  ExpectError<DataError>([&] { ReadDepthMap(folder / "a.png"); }, {"a.png", "OpenEXR"});
  DepthMap map = PlaneDepth({0, 0, 1}, 3);
  for (const float wrong : {-1.0f, INFINITY, NAN}) {
    map.At(1, 1) = wrong;
    WriteDepthMap(folder / "b.exr", map);
    ExpectError<DataError>([&] { ReadDepthMap(folder / "b.exr"); }, {"b.exr", "depth"});
  }
}

TEST(DepthMap, DistanceAlongTheRayAndDepthBelongToOnePoint) {
  const glm::ivec2 pixel(3, 27);
  const glm::dvec3 point = 2.5 * kCamera.CamFromImage(glm::dvec2(pixel) + 0.5);
  EXPECT_NEAR(DepthOfDistance(kCamera, pixel, glm::length(point)), 2.5, 1e-12);
}

TEST(NormalPicture, APlaneHasItsNormalEverywhere) {
  const glm::dvec3 n = glm::normalize(glm::dvec3(0.3, -0.2, 1));
  const Image image = NormalPicture(PlaneDepth(n, 3), kCamera);
  // Towards the camera: -n, shown with y up and z to the camera.
  const glm::dvec3 shown(-n.x, n.y, n.z);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        // Half a level of rounding, and that of float depths.
        EXPECT_NEAR(image.At(x, y)[c], 127.5 * (shown[c] + 1), 0.6) << x << " " << y;
      }
    }
  }
}

TEST(NormalPicture, AnEdgeBetweenTwoPlanesStaysSharp) {
  DepthMap map = PlaneDepth({0, 0, 1}, 3);
  const DepthMap behind = PlaneDepth({0, 0, 1}, 5);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 20; x < map.width; ++x) map.At(x, y) = behind.At(x, y);
  }
  const Image image = NormalPicture(map, kCamera);
  for (int x = 0; x < image.width; ++x) EXPECT_GE(image.At(x, 10)[2], 254) << x;
}

TEST(ColoredDepth, NearIsBrighterThanFarAndNothingIsGrey) {
  DepthMap map = MakeDepthMap(3, 1);
  map.At(0, 0) = 1;
  map.At(1, 0) = 4;
  const Image image = ColoredDepth(map, RangeOf(map));
  const auto brightness = [&](int x) {
    return image.At(x, 0)[0] + image.At(x, 0)[1] + image.At(x, 0)[2];
  };
  EXPECT_GT(brightness(0), brightness(1));
  EXPECT_EQ(image.At(2, 0)[0], image.At(2, 0)[2]);
  // A map without any surface is grey, too.
  const Image none = ColoredDepth(MakeDepthMap(2, 2), RangeOf(MakeDepthMap(2, 2)));
  EXPECT_EQ(none.pixels[0], none.pixels[2]);
}

}  // namespace
}  // namespace tetrec
