#include "surface/align_with_photos.h"

#include "surface/photo_differences.h"
#include "surface/shapes.h"
#include "surface/textured_shapes.h"
#include "surface/vertex_fans.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

constexpr double kFootprint = 4.0 / 220;  // of the photos' pixels at the origin

// Random greys at the corners of cells of 4 pixels, linear between them.
glm::dvec3 Speckles(const glm::dvec3& p) {
  const glm::dvec3 place = p / (4 * kFootprint) + 0.3, cell = glm::floor(place);
  const glm::dvec3 t = place - cell;
  double grey = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
    const glm::dvec3 weight = glm::mix(1.0 - t, t, step);
    const double hash =
        std::sin(glm::dot(cell + step, glm::dvec3(12.9898, 78.233, 37.719))) * 43758.5453;
    grey += weight.x * weight.y * weight.z * (hash - std::floor(hash));
  }
  return glm::dvec3(grey);
}

// [-1, 1]^2 in the plane z = 0.
TriangleMesh Wall(uint32_t cells = 40) {
  TriangleMesh wall;
  for (uint32_t y = 0; y <= cells; ++y) {
    for (uint32_t x = 0; x <= cells; ++x) {
      wall.positions.emplace_back(2 * float(x) / float(cells) - 1, 2 * float(y) / float(cells) - 1,
                                  0);
      const uint32_t v = y * (cells + 1) + x, above = v + cells + 1;
      if (x == cells || y == cells) continue;
      wall.triangles.emplace_back(v, v + 1, above + 1);
      wall.triangles.emplace_back(v, above + 1, above);
    }
  }
  return wall;
}

// Two pixels too deep, and one more or less from place to place.
TriangleMesh Dented(TriangleMesh wall) {
  for (glm::vec3& p : wall.positions) {
    p.z -= float(kFootprint * (2 + std::sin(5.0 * p.x) * std::cos(4.0 * p.y)));
  }
  return wall;
}

std::vector<TexturePhoto> PhotosFromAbove(const TriangleMesh& mesh, const Paint& paint) {
  std::vector<TexturePhoto> photos;
  for (const glm::dvec2 side : {glm::dvec2(0, 0), {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
    const double gain = 0.6 + 0.1 * double(photos.size());
    photos.push_back(PhotoOf(mesh, paint, 4.0 * glm::normalize(glm::dvec3(side, 2)), gain, 0.02));
  }
  return photos;
}

// A wall that is bent along y at a right angle, with the edge towards the cameras.
TriangleMesh Ridge(uint32_t cells) {
  TriangleMesh ridge = Wall(cells);
  for (glm::vec3& p : ridge.positions) p.z = -std::abs(p.x);
  return ridge;
}

// Mean distance from the wall, without its border, which photos do not place.
double ErrorOf(const TriangleMesh& mesh) {
  double sum = 0, count = 0;
  for (const glm::vec3& p : mesh.positions) {
    if (std::max(std::abs(p.x), std::abs(p.y)) > 0.8f) continue;
    sum += std::abs(p.z);
    count += 1;
  }
  return sum / count;
}

// With the error of two whole surfaces as the reference. Its gradient comes from the pictures, so
// it is only as exact as they are smooth.
TEST(CompareWithPhotos, ThePullIsTheRateAtWhichTheErrorFalls) {
  const std::vector<TexturePhoto> photos = PhotosFromAbove(Wall(), Speckles);
  std::vector<glm::vec3> colors;
  for (const glm::vec3& p : Wall().positions) colors.emplace_back(Speckles(glm::dvec3(p)));
  for (const glm::vec3 direction : {glm::vec3(0, 0, 1), glm::vec3(1, 0, 0)}) {
    const auto differences_at = [&](double pixels) {
      TriangleMesh wall = Wall();
      for (glm::vec3& p : wall.positions) p += float(pixels * kFootprint) * direction;
      return CompareWithPhotos(wall, BorderVertices(wall), ColorsOfVertices(wall, colors), photos);
    };
    constexpr double kOff = 0.5, kStep = 0.1;  // [footprints]
    const double pixels = [&] {
      double count = 0;
      for (const VertexDifferences& v : differences_at(kOff).vertices) count += double(v.seen);
      return count;
    }();
    const double falls = -pixels * 3 *
                         (differences_at(kOff + kStep).mean_squared_local_error -
                          differences_at(kOff - kStep).mean_squared_local_error) /
                         (2 * kStep);
    double pull = 0;
    for (const VertexDifferences& v : differences_at(kOff).vertices) {
      pull += 2 * double(glm::dot(v.pull, direction));
    }
    EXPECT_LT(falls, 0);
    EXPECT_NEAR(pull / falls, 1, 0.3);
  }
}

TEST(CompareWithPhotos, ColoursOfTheirOwnAreAllThatAFlatWallInItsPlaceNeeds) {
  const std::vector<TexturePhoto> photos =
      PhotosFromAbove(Wall(), [](const glm::dvec3&) { return glm::dvec3(0.25, 0.5, 0.75); });
  const TriangleMesh wall = Wall();
  const std::vector<glm::vec3> grey(wall.positions.size(), glm::vec3(0.5f));
  const PhotoDifferences differences =
      CompareWithPhotos(wall, BorderVertices(wall), ColorsOfVertices(wall, grey), photos);
  EXPECT_NEAR(differences.mean_squared_error, 2 * 0.25 * 0.25 / 3, 1e-3);
  EXPECT_LT(differences.mean_squared_local_error, 1e-5);
  size_t seen = 0;
  for (const VertexDifferences& v : differences.vertices) {
    if (!(v.color_weight > 0)) continue;
    const glm::vec3 error = v.color_error / v.color_weight;
    EXPECT_NEAR(error.x, -0.25, 0.01);
    EXPECT_NEAR(error.y, 0, 0.01);
    EXPECT_NEAR(error.z, 0.25, 0.01);
    EXPECT_LT(glm::length(v.pull), 1e-4f);
    ++seen;
  }
  EXPECT_GT(seen, differences.vertices.size() / 2);
}

// Light that stands still while the subject turns, and exposure, differ from photo to photo. A wall
// in its place must not follow them.
TEST(CompareWithPhotos, LightThatVariesSlowlyOverAPhotoDoesNotPull) {
  std::vector<TexturePhoto> photos = PhotosFromAbove(Wall(), Speckles);
  const TriangleMesh wall = Wall();
  std::vector<glm::vec3> colors;
  for (const glm::vec3& p : wall.positions) colors.emplace_back(Speckles(glm::dvec3(p)));
  const auto compare = [&] {
    return CompareWithPhotos(wall, BorderVertices(wall), ColorsOfVertices(wall, colors), photos);
  };
  const PhotoDifferences even = compare();
  for (size_t i = 0; i < photos.size(); ++i) {
    Image& image = photos[i].image;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const double lit = 40 * std::sin(0.02 * x * double(i % 3) + 0.015 * y * double(i % 2));
        for (int c = 0; c < 3; ++c) {
          image.At(x, y)[c] = uint8_t(std::clamp(image.At(x, y)[c] + lit, 0.0, 255.0));
        }
      }
    }
  }
  const PhotoDifferences lit = compare();
  EXPECT_GT(lit.mean_squared_error, 5 * even.mean_squared_error);
  EXPECT_LT(lit.mean_squared_local_error, 1.2 * even.mean_squared_local_error);
  const TriangleMesh start = Dented(wall);
  EXPECT_LT(ErrorOf(AlignWithPhotos(start, photos, 12).mesh), 0.3 * ErrorOf(start));
}

TEST(CompareWithPhotos, ItsPicturesAreThoseOfTheSurface) {
  TriangleMesh wall = Dented(Wall());
  for (const glm::vec3& p : wall.positions) {
    const glm::dvec3 color = 255.0 * Speckles(glm::dvec3(p));
    wall.colors_srgb.push_back({uint8_t(color.x), uint8_t(color.y / 2), uint8_t(color.z / 3)});
  }
  const std::vector<TexturePhoto> photos = PhotosFromAbove(Wall(), Speckles);
  std::vector<SurfacePicture> pictures(photos.size());
  CompareWithPhotos(wall, BorderVertices(wall), ColorsOfVertices(wall, VertexColors(wall)), photos,
                    pictures);
  for (size_t i = 0; i < photos.size(); ++i) {
    const SurfacePicture drawn = DrawSurface(wall, {}, photos[i].camera, photos[i].cam_from_world);
    EXPECT_EQ(pictures[i].covered, drawn.covered);
    ASSERT_EQ(pictures[i].image.pixels.size(), drawn.image.pixels.size());
    for (size_t k = 0; k < drawn.image.pixels.size(); ++k) {
      EXPECT_NEAR(pictures[i].image.pixels[k], drawn.image.pixels[k], 1);
    }
  }
}

TEST(AlignWithPhotos, AWallThatIsTooDeepAndDentedBecomesThatOfThePhotos) {
  const TriangleMesh dented = Dented(Wall());
  std::vector<TexturePhoto> photos = PhotosFromAbove(Wall(), Speckles);
  const AlignedSurface aligned = AlignWithPhotos(dented, photos, 12);
  EXPECT_GT(ErrorOf(dented), 1.8 * kFootprint);
  EXPECT_LT(ErrorOf(aligned.mesh), 0.3 * kFootprint);
  EXPECT_NEAR(aligned.mean_move_px, 2, 0.5);
  EXPECT_EQ(aligned.mesh.triangles, dented.triangles);
}

// Mean height above or below such a ridge.
double ErrorOfRidge(const TriangleMesh& mesh) {
  double sum = 0;
  for (const glm::vec3& p : mesh.positions) sum += std::abs(p.z + std::abs(p.x));
  return sum / double(mesh.positions.size());
}

// If the edge folded, it would be taken back to where it was.
TEST(AlignWithPhotos, AnEdgeWhoseTrianglesAreSmallerThanTheMovesMovesToo) {
  const TriangleMesh ridge = Ridge(200);
  TriangleMesh high = ridge;
  for (glm::vec3& p : high.positions) p.z += float(2 * kFootprint);
  std::vector<TexturePhoto> photos = PhotosFromAbove(ridge, Speckles);
  const TriangleMesh aligned = AlignWithPhotos(high, photos, 12).mesh;
  EXPECT_LT(ErrorOfRidge(aligned), 0.3 * ErrorOfRidge(high));
}

double MeanRadius(const TriangleMesh& mesh) {
  double sum = 0;
  for (const glm::vec3& p : mesh.positions) sum += double(glm::length(p));
  return sum / double(mesh.positions.size());
}

TriangleMesh Scaled(TriangleMesh mesh, float scale) {
  for (glm::vec3& p : mesh.positions) p *= scale;
  return mesh;
}

// Plain grey, with the ball as alpha.
std::vector<TexturePhoto> OpaquePhotosOf(const TriangleMesh& ball) {
  std::vector<TexturePhoto> photos =
      PhotosAround(ball, [](const glm::dvec3&) { return glm::dvec3(0.5); });
  for (TexturePhoto& photo : photos) {
    const Image rgb = photo.image;
    photo.image = MakeImage(rgb.width, rgb.height, 4);
    photo.alpha_is_opacity = true;
    for (int y = 0; y < rgb.height; ++y) {
      for (int x = 0; x < rgb.width; ++x) {
        std::copy_n(rgb.At(x, y), 3, photo.image.At(x, y));
        const bool seen = std::isfinite(photo.depth[photo.Index(x, y)]);
        photo.image.At(x, y)[3] = seen ? 255 : 0;
      }
    }
  }
  return photos;
}

constexpr double kBallFootprint = 4.5 / 220;

// Without texture, only outlines show how large a ball is.
TEST(AlignWithPhotos, OutlinesMoveWhereAlphaIsOpacity) {
  const TriangleMesh ball = Sphere(0.6, {0, 0, 0});
  const std::vector<TexturePhoto> photos = OpaquePhotosOf(ball);
  const double radius = MeanRadius(ball);
  for (const double off : {-1.0, 1.0}) {
    const TriangleMesh start = Scaled(ball, float(1 + off * kBallFootprint / radius));
    const double left =
        (MeanRadius(AlignWithPhotos(start, photos, 12).mesh) - radius) / kBallFootprint;
    EXPECT_LT(std::abs(left), 0.35) << off;
  }
}

// Photos from below show the half that was cut off, and its outline; the surface shows its back.
TEST(AlignWithPhotos, WhatWasCutOffDoesNotPull) {
  const TriangleMesh ball = Sphere(0.6, {0, 0, 0});
  TriangleMesh upper = ball;
  std::erase_if(upper.triangles, [&](const glm::uvec3& t) {
    return std::min({ball.positions[t.x].z, ball.positions[t.y].z, ball.positions[t.z].z}) < 0;
  });
  const TriangleMesh aligned = AlignWithPhotos(upper, OpaquePhotosOf(ball), 8).mesh;
  float farthest = 0;
  for (size_t v = 0; v < upper.positions.size(); ++v) {
    farthest = std::max(farthest, glm::distance(upper.positions[v], aligned.positions[v]));
  }
  EXPECT_LT(farthest, 0.25 * kBallFootprint);
}

// What is masked out is of another colour, and that has no effect.
TEST(AlignWithPhotos, PixelsThatDoNotCountHaveNoEffect) {
  std::vector<TexturePhoto> photos = PhotosFromAbove(Wall(), Speckles);
  for (TexturePhoto& photo : photos) {
    const Image rgb = photo.image;
    photo.image = MakeImage(rgb.width, rgb.height, 4);
    for (int y = 0; y < rgb.height; ++y) {
      for (int x = 0; x < rgb.width; ++x) {
        std::copy_n(rgb.At(x, y), 3, photo.image.At(x, y));
        photo.image.At(x, y)[3] = x < rgb.width / 2 ? 255 : 0;
      }
    }
  }
  std::vector<TexturePhoto> masked = photos;
  for (TexturePhoto& photo : masked) {
    for (int y = 0; y < photo.image.height; ++y) {
      for (int x = photo.image.width / 2; x < photo.image.width; ++x) {
        std::fill_n(photo.image.At(x, y), 3, uint8_t(17 * (x + y)));
      }
    }
  }
  const TriangleMesh dented = Dented(Wall());
  EXPECT_EQ(AlignWithPhotos(dented, masked, 2).mesh.positions,
            AlignWithPhotos(dented, photos, 2).mesh.positions);
  EXPECT_NE(AlignWithPhotos(dented, photos, 2).mesh.positions, dented.positions);
}

TEST(AlignWithPhotos, ASurfaceThatThePhotosDoNotPlaceStays) {
  const TriangleMesh dented = Dented(Wall());
  std::vector<TexturePhoto> plain =
      PhotosFromAbove(Wall(), [](const glm::dvec3&) { return glm::dvec3(0.5); });
  const TriangleMesh unmoved = AlignWithPhotos(dented, plain, 3).mesh;
  for (size_t v = 0; v < dented.positions.size(); ++v) {
    EXPECT_LT(glm::distance(unmoved.positions[v], dented.positions[v]), 0.02 * kFootprint);
  }
  std::vector<TexturePhoto> photos = PhotosFromAbove(Wall(), Speckles);
  EXPECT_EQ(AlignWithPhotos(dented, std::span(photos).first(1), 3).mesh.positions,
            dented.positions);
  EXPECT_EQ(AlignWithPhotos(dented, photos, 0).mesh.positions, dented.positions);
}

}  // namespace
}  // namespace tetrec
