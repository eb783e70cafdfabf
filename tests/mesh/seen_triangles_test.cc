#include "mesh/seen_triangles.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetrec {
namespace {

const Camera kCamera{40, 30, 30.0, 32.0, 20.5, 14.25};

// A large square behind a small triangle, both facing the camera, which looks along +z.
TriangleMesh TwoLayers() {
  TriangleMesh mesh;
  mesh.positions = {{-9, -9, 4},       {9, -9, 4},       {9, 9, 4},      {-9, 9, 4},
                    {-0.4f, -0.4f, 2}, {-0.4f, 0.4f, 2}, {0.5f, 0, 2.5f}};
  mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}};
  return mesh;
}

TEST(SeenTriangles, TheNearestOneIsSeenAtItsDepth) {
  const TriangleMesh mesh = TwoLayers();
  const SeenTriangles seen = FindSeenTriangles(mesh, kCamera, {});
  int small = 0;
  for (int y = 0; y < kCamera.height; ++y) {
    for (int x = 0; x < kCamera.width; ++x) {
      const uint32_t triangle = seen.triangle[seen.Index(x, y)];
      ASSERT_NE(triangle, kNoTriangle) << x << ", " << y;  // no gap along the square's diagonal
      if (triangle != 2) {
        EXPECT_NEAR(seen.depth[seen.Index(x, y)], 4, 1e-5);
        continue;
      }
      ++small;
      const glm::dvec3 weights = CornerWeights(mesh, 2, kCamera, {}, {x + 0.5, y + 0.5});
      glm::dvec3 point(0.0);
      for (int k = 0; k < 3; ++k) {
        EXPECT_GE(weights[k], -1e-12) << x << ", " << y;
        point += weights[k] * glm::dvec3(mesh.positions[mesh.triangles[2][k]]);
      }
      EXPECT_NEAR(seen.depth[seen.Index(x, y)], point.z, 1e-5);
      EXPECT_LT(glm::distance(kCamera.ImageFromCam(point), {x + 0.5, y + 0.5}), 1e-9);
    }
  }
  // Its area in pixels: the corners are projected by hand.
  const glm::dvec2 a = kCamera.ImageFromCam({-0.4, -0.4, 2}),
                   b = kCamera.ImageFromCam({-0.4, 0.4, 2}),
                   c = kCamera.ImageFromCam({0.5, 0, 2.5});
  const double area = 0.5 * std::abs((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x));
  EXPECT_NEAR(small, area, 0.1 * area);
}

TEST(SeenTriangles, ATriangleThatPassesTheCameraIsCutOffInItsPlane) {
  TriangleMesh mesh;
  // The ground below the camera, from behind it to far away; y points down.
  mesh.positions = {{-99, 1, -5}, {99, 1, -5}, {0, 1, 500}};
  mesh.triangles = {{0, 1, 2}};
  const SeenTriangles seen = FindSeenTriangles(mesh, kCamera, {});
  for (int y = 0; y < kCamera.height; ++y) {
    const glm::dvec3 ray = kCamera.CamFromImage({20.5, y + 0.5});
    const bool below = ray.y > 1.0 / 400;
    if (std::abs(ray.y) < 1.0 / 400) continue;
    EXPECT_EQ(seen.triangle[seen.Index(20, y)], below ? 0u : kNoTriangle) << "row " << y;
    if (below) {
      EXPECT_NEAR(seen.depth[seen.Index(20, y)] * ray.y, 1, 1e-5);
    }
  }
}

TEST(SeenTriangles, NothingIsSeenBehindTheCameraOrInAnEmptyMesh) {
  const Rigid3 turned{glm::dmat3({-1, 0, 0}, {0, 1, 0}, {0, 0, -1}), glm::dvec3(0.0)};
  for (const TriangleMesh& mesh : {TwoLayers(), TriangleMesh{}}) {
    for (const uint32_t triangle : FindSeenTriangles(mesh, kCamera, turned).triangle) {
      ASSERT_EQ(triangle, kNoTriangle);
    }
  }
}

}  // namespace
}  // namespace tetrec
