#include "surface/texture_fit.h"

#include "surface/texels.h"
#include "surface/texture_bake.h"
#include "surface/texture_charts.h"
#include "surface/texture_error.h"
#include "surface/textured_shapes.h"

#include <gtest/gtest.h>

namespace tetrec {
namespace {

TriangleMesh WithCoordinates(TriangleMesh mesh, const TextureLayout& layout) {
  mesh.corner_coordinates = CornerCoordinates(layout);
  return mesh;
}

// Each pixel becomes the mean of what it covers, which `photo` shows in four.
TexturePhoto OfHalfTheSize(TexturePhoto photo, const TriangleMesh& mesh) {
  const Camera& fine = photo.camera;
  photo.camera = {fine.width / 2, fine.height / 2, fine.fx / 2,
                  fine.fy / 2,    fine.cx / 2,     fine.cy / 2};
  photo.image = ResizeByArea(photo.image, photo.camera.width, photo.camera.height);
  FindTrust(mesh, photo);
  return photo;
}

TEST(FitTexture, ABakedTextureComesNearerToThePaintWhateverThePhotosExposure) {
  const TriangleMesh cube = GreyCube();
  std::vector<TexturePhoto> photos;
  for (const TexturePhoto& photo : PhotosAround(cube, Waves)) {
    photos.push_back(OfHalfTheSize(photo, cube));
  }
  const TextureLayout layout =
      LayOutTexture(cube, CutIntoCharts(cube), MedianFootprint(cube, photos), 1024);
  Image texture = BakeTexture(cube, layout, photos).image;
  const TexelError baked = ErrorOf(cube, layout, texture, Waves);
  FitTexture(WithCoordinates(cube, layout), layout, photos, texture);
  const TexelError fitted = ErrorOf(cube, layout, texture, Waves);
  EXPECT_LT(fitted.texture, 0.8 * baked.texture);
}

TEST(FitTexture, WhatNoPhotoSeesStaysAsItWas) {
  const TriangleMesh mesh = WallBehindPlate();
  const Paint green = [](const glm::dvec3&) { return glm::dvec3(0, 1, 0); };
  const std::vector<TexturePhoto> photos = {PhotoOf(mesh, green, {0, 0, 4})};
  const TextureLayout layout = LayOutTextureOfSize(mesh, CutIntoCharts(mesh), 256);
  Image texture = MakeImage(256, 256, 3);
  FitTexture(WithCoordinates(mesh, layout), layout, photos, texture);
  const Texels texels = FindTexels(layout);
  int hidden = 0, seen = 0;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      const uint32_t t = texels.triangle[size_t(y) * 256 + size_t(x)];
      if (t > 1) continue;  // the plate, or nothing
      const uint8_t* rgb = texture.At(x, y);
      EXPECT_EQ(rgb[0], 0);
      // The wall's middle is in the plate's shadow, which reaches to two thirds of its sides.
      const glm::dvec3 weights = NearestWeights(layout.corners[t], {x + 0.5, y + 0.5});
      glm::dvec3 point(0.0);
      for (int k = 0; k < 3; ++k) {
        point += weights[k] * glm::dvec3(mesh.positions[mesh.triangles[t][k]]);
      }
      const double reach = std::max(std::abs(point.x), std::abs(point.y));
      if (reach < 0.6) {
        EXPECT_EQ(rgb[1], 0);
        ++hidden;
      } else if (reach > 0.75 && reach < 0.9) {
        EXPECT_GT(rgb[1], 240);
        ++seen;
      }
    }
  }
  EXPECT_GT(hidden, 1000);
  EXPECT_GT(seen, 1000);
}

// A crop may leave the wall and cut off the plate, which photos still show.
TEST(FitTexture, WhatHidesTheSurfaceLeavesNoColourOnIt) {
  const TriangleMesh both = WallBehindPlate();
  TriangleMesh wall = both, plate = both;
  wall.triangles = {both.triangles[0], both.triangles[1]};
  wall.colors_srgb.assign(8, {0, 255, 0});
  plate.triangles = {both.triangles[2], both.triangles[3]};
  const Paint red_plate = [](const glm::dvec3& p) {
    return p.z > 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  };
  std::vector<TexturePhoto> photos = {PhotoOf(both, red_plate, {0, 0, 4}),
                                      PhotoOf(both, red_plate, {1.3, 0.4, 4})};
  FindTrust(wall, photos, plate);
  const TextureLayout layout = LayOutTextureOfSize(wall, CutIntoCharts(wall), 256);
  Image texture = BakeTexture(wall, layout, photos).image;
  FitTexture(WithCoordinates(wall, layout), layout, photos, texture);
  const Texels texels = FindTexels(layout);
  int on_wall = 0;
  for (int y = 0; y < 256; ++y) {
    for (int x = 0; x < 256; ++x) {
      if (texels.triangle[size_t(y) * 256 + size_t(x)] == kNoTriangle) continue;
      EXPECT_EQ(texture.At(x, y)[0], 0) << x << ", " << y;
      ++on_wall;
    }
  }
  EXPECT_GT(on_wall, 10000);
}

}  // namespace
}  // namespace tetrec
