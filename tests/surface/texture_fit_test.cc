#include "surface/texture_fit.h"

#include "surface/texels.h"
#include "surface/texture_bake.h"
#include "surface/texture_charts.h"
#include "surface/texture_error.h"
#include "surface/textured_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

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
  TriangleMesh still = WithCoordinates(cube, layout);
  FitTexture(still, layout, photos, 0, texture);
  EXPECT_EQ(still.positions, cube.positions);
  const TexelError fitted = ErrorOf(cube, layout, texture, Waves);
  EXPECT_LT(fitted.texture, 0.8 * baked.texture);
}

TEST(FitTexture, WhatNoPhotoSeesStaysAsItWas) {
  const TriangleMesh mesh = WallBehindPlate();
  const Paint green = [](const glm::dvec3&) { return glm::dvec3(0, 1, 0); };
  std::vector<TexturePhoto> photos = {PhotoOf(mesh, green, {0, 0, 4})};
  const TextureLayout layout = LayOutTextureOfSize(mesh, CutIntoCharts(mesh), 256);
  Image texture = MakeImage(256, 256, 3);
  TriangleMesh fitted = WithCoordinates(mesh, layout);
  FitTexture(fitted, layout, photos, 2, texture);
  EXPECT_EQ(fitted.positions, mesh.positions);  // one photo places nothing
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
  TriangleMesh fitted = WithCoordinates(wall, layout);
  FitTexture(fitted, layout, photos, 0, texture);
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

// A wall in the plane z = 0, of which each vertex is off by up to a pixel of the photos, which are
// painted with waves far finer than the wall's triangles.
TEST(FitTexture, AWallWhoseVerticesAreTooFewForItsColoursMovesToItsPlace) {
  TriangleMesh flat;
  constexpr uint32_t kCells = 8;
  for (uint32_t y = 0; y <= kCells; ++y) {
    for (uint32_t x = 0; x <= kCells; ++x) {
      flat.positions.emplace_back(2 * float(x) / kCells - 1, 2 * float(y) / kCells - 1, 0);
      flat.colors_srgb.push_back({128, 128, 128});
      const uint32_t v = y * (kCells + 1) + x, above = v + kCells + 1;
      if (x == kCells || y == kCells) continue;
      flat.triangles.emplace_back(v, v + 1, above + 1);
      flat.triangles.emplace_back(v, above + 1, above);
    }
  }
  std::vector<TexturePhoto> photos;
  for (const glm::dvec2 side : {glm::dvec2(0, 0), {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
    photos.push_back(PhotoOf(flat, Waves, 4.0 * glm::normalize(glm::dvec3(side, 2))));
  }
  TriangleMesh dented = flat;
  for (glm::vec3& p : dented.positions) p.z = 0.018f * std::sin(5 * p.x) * std::cos(4 * p.y);
  FindTrust(dented, photos);
  const TextureLayout layout = LayOutTextureOfSize(dented, CutIntoCharts(dented), 256);
  const auto fit = [&](int moves) {
    TriangleMesh mesh = WithCoordinates(dented, layout);
    Image texture = BakeTexture(mesh, layout, photos).image;
    const TextureFit result = FitTexture(mesh, layout, photos, moves, texture);
    double off = 0;
    for (const glm::vec3& p : mesh.positions) {
      if (std::max(std::abs(p.x), std::abs(p.y)) < 0.9f) off += double(std::abs(p.z));
    }
    return std::tuple(off, result.mean_move_px, ErrorOf(flat, layout, texture, Waves).texture);
  };
  const auto [still_off, still_px, still_error] = fit(0);
  const auto [moved_off, moved_px, moved_error] = fit(6);
  EXPECT_LT(moved_off, 0.5 * still_off);
  EXPECT_GT(moved_px, 0.1);
  EXPECT_EQ(still_px, 0);
  EXPECT_LT(std::max(moved_error, still_error), 0.01);
}

}  // namespace
}  // namespace tetrec
