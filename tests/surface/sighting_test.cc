// Which photos see which triangles.
#include "surface/sighting.h"

#include "mesh/triangle_shapes.h"
#include "surface/textured_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

// Photos of a mesh around the origin from above, ever farther to the side.
std::vector<TexturePhoto> PhotosFromAbove(const TriangleMesh& mesh, int count) {
  std::vector<TexturePhoto> photos;
  for (int i = 0; i < count; ++i) {
    const double angle = 0.04 * i;
    photos.push_back(PhotoOf(mesh, Waves, {4.5 * std::sin(angle), 0, 4.5 * std::cos(angle)}));
  }
  return photos;
}

TriangleMesh CenteredPlane(int squares) {
  TriangleMesh plane = Plane(squares, 2, 0);
  for (glm::vec3& p : plane.positions) p -= glm::vec3(1, 1, 0);
  return plane;
}

TEST(PhotosOfTriangles, SmallTrianglesHaveThePhotosThatSeeThemFromTheFrontAndLargeOnesAll) {
  const TriangleMesh small = CenteredPlane(60);
  const PhotosByTriangle of_small = PhotosOfTriangles(small, PhotosFromAbove(small, 30));
  std::vector<uint32_t> first(24);
  for (uint32_t i = 0; i < first.size(); ++i) first[i] = i;
  // The square around the origin; later photos see it ever flatter.
  EXPECT_EQ(of_small.photos[size_t(2 * (30 * 60 + 30))], first);
  EXPECT_EQ(of_small.limited, small.triangles.size());

  const TriangleMesh large = CenteredPlane(2);
  const PhotosByTriangle of_large = PhotosOfTriangles(large, PhotosFromAbove(large, 30));
  for (const auto& photos : of_large.photos) EXPECT_EQ(photos.size(), 30u);
  EXPECT_EQ(of_large.limited, 0u);
}

TEST(PhotosOfTriangles, AreNotThoseFromWhichSomethingIsInFront) {
  const TriangleMesh cube = GreyCube();
  const std::vector<TexturePhoto> photos{PhotoOf(cube, Waves, {0, 0, 4.5}),
                                         PhotoOf(cube, Waves, {0, 0, -4.5})};
  // The sides have vertices that the photos show, but the far face has none.
  const PhotosByTriangle by_triangle = PhotosOfTriangles(cube, photos);
  for (size_t t = 0; t < cube.triangles.size(); ++t) {
    const auto z = [&](int k) { return cube.positions[cube.triangles[t][k]].z; };
    const bool seen_from_above = std::max({z(0), z(1), z(2)}) > 0;
    const auto& ids = by_triangle.photos[t];
    EXPECT_EQ(std::count(ids.begin(), ids.end(), 0u), seen_from_above) << t;
  }
}

// Rays of a far photo meet one triangle of some fifty; all are seen.
TEST(PhotosOfTriangles, OfTrianglesFarSmallerThanAPixelSeeThemAll) {
  const TriangleMesh fine = CenteredPlane(300);
  const std::vector<TexturePhoto> photos{PhotoOf(fine, Waves, {0, 0, 15})};
  for (const auto& ids : PhotosOfTriangles(fine, photos).photos) ASSERT_EQ(ids.size(), 1u);
}

}  // namespace
}  // namespace tetrec
