// Normal maps: from depths, and their files.
#include "image/normal_map.h"

#include "core/error.h"
#include "expect_error.h"
#include "image/plane_depth.h"
#include "scratch_folder.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

TEST(NormalsOf, APlaneHasItsNormalEverywhereInWhicheverFrame) {
  const glm::dvec3 n = glm::normalize(glm::dvec3(0.3, -0.2, 1));
  const NormalMap in_cam = NormalsOf(PlaneDepth(n, 3), kCamera);
  const glm::dmat3 quarter_turn(0, 1, 0, -1, 0, 0, 0, 0, 1);  // x to y, y to -x
  const NormalMap turned = Rotated(quarter_turn, in_cam);
  for (size_t i = 0; i < in_cam.normal.size(); ++i) {
    EXPECT_LT(glm::distance(glm::dvec3(in_cam.normal[i]), -n), 1e-4) << i;
    EXPECT_LT(glm::distance(glm::dvec3(turned.normal[i]), glm::dvec3(n.y, -n.x, -n.z)), 1e-4);
  }
}

TEST(NormalsOf, ASphereHasThoseOfItsEquation) {
  const Camera camera{200, 160, 250, 250, 100, 80};
  const glm::dvec3 center(0.1, -0.2, 5);
  DepthMap map = MakeDepthMap(camera.width, camera.height);
  NormalMap want = MakeNormalMap(camera.width, camera.height);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const glm::dvec3 d = camera.CamFromImage({x + 0.5, y + 0.5});
      const double a = glm::dot(d, d), b = glm::dot(d, center);
      const double inside = b * b - a * (glm::dot(center, center) - 1);
      if (inside < 0) continue;
      const double depth = (b - std::sqrt(inside)) / a;
      map.At(x, y) = float(depth);
      want.At(x, y) = glm::vec3(depth * d - center);
    }
  }
  const NormalMap got = NormalsOf(map, camera);
  int judged = 0;
  for (size_t i = 0; i < want.normal.size(); ++i) {
    const glm::vec3& n = want.normal[i];
    EXPECT_EQ(n == glm::vec3(0.0f), got.normal[i] == glm::vec3(0.0f) && map.depth[i] == kNoDepth);
    if (!(n.z < -0.6)) continue;  // differences are coarse where the sphere bends away
    EXPECT_GT(glm::dot(n, got.normal[i]), std::cos(0.04)) << i;
    ++judged;
  }
  EXPECT_GT(judged, 3000);
}

TEST(NormalsOf, WithoutANeighborThereIsNoNormal) {
  DepthMap map = MakeDepthMap(3, 3);
  map.At(1, 1) = map.At(1, 0) = 2;
  for (const glm::vec3& normal : NormalsOf(map, kCamera).normal) {
    EXPECT_EQ(normal, glm::vec3(0.0f));
  }
}

TEST(NormalMap, AFileGivesTheSameBitsAgain) {
  const ScratchFolder folder;
  NormalMap map = NormalsOf(PlaneDepth({0.1, 0.2, 1}, 3), kCamera);
  map.At(3, 4) = glm::vec3(0.0f);
  map.At(5, 6) = {0, -1, 0};
  WriteNormalMap(folder / "a.exr", map);
  const NormalMap read = ReadNormalMap(folder / "a.exr");
  EXPECT_EQ(read.width, map.width);
  EXPECT_EQ(read.height, map.height);
  EXPECT_EQ(read.normal, map.normal);
}

TEST(NormalMap, WhatIsNoNormalMapIsRefused) {
  const ScratchFolder folder;
  WriteImage(folder / "a.png", MakeImage(4, 4, 3));
  ExpectError<DataError>([&] { ReadNormalMap(folder / "a.png"); }, {"a.png", "OpenEXR"});
  WriteDepthMap(folder / "depth.exr", PlaneDepth({0, 0, 1}, 3));
  ExpectError<DataError>([&] { ReadNormalMap(folder / "depth.exr"); },
                         {"depth.exr", "three channels"});
  NormalMap map = MakeNormalMap(4, 4);
  for (const float wrong : {2.0f, INFINITY, NAN}) {
    map.At(1, 1) = {0, wrong, 0};
    WriteNormalMap(folder / "b.exr", map);
    ExpectError<DataError>([&] { ReadNormalMap(folder / "b.exr"); }, {"b.exr", "length"});
  }
}

}  // namespace
}  // namespace tetrec
