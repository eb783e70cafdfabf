#include "mesh/seen_triangles.h"

#include "core/random.h"
#include "core/timer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

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

// Whether the ray meets the triangle in front of the camera (Moeller and Trumbore 1997); nothing
// where rounding decides.
std::optional<bool> Meets(const glm::dvec3& ray, const std::array<glm::dvec3, 3>& corners) {
  const glm::dvec3 ab = corners[1] - corners[0], ac = corners[2] - corners[0];
  const glm::dvec3 p = glm::cross(ray, ac), q = glm::cross(-corners[0], ab);
  const double scale = glm::dot(ab, p);
  const double u = -glm::dot(corners[0], p) / scale, v = glm::dot(ray, q) / scale;
  const double distance = glm::dot(ac, q) / scale;
  const double least = std::min({u, v, 1 - u - v, distance});
  if (std::abs(least) < 1e-6) return std::nullopt;
  return least > 0;
}

TEST(SeenTriangles, AreThoseThatRaysMeetAllAroundTheCamera) {
  MersenneRandom random(4);
  TriangleMesh mesh;
  mesh.triangles = {{0, 1, 2}};
  int seen_and_crossing = 0;
  for (int turn = 0; turn < 400; ++turn) {
    std::array<glm::dvec3, 3> corners;
    for (glm::dvec3& corner : corners) {
      corner = {random.Uniform() - 0.5, random.Uniform() - 0.5, random.Uniform() - 0.5};
      if (turn % 4 == 0) corner.x = 0.5;  // a wall along the axis
      corner = glm::dvec3(glm::vec3(corner));
    }
    if (turn % 8 == 1) corners[0].z = 0;
    mesh.positions.assign(corners.begin(), corners.end());
    const SeenTriangles seen = FindSeenTriangles(mesh, kCamera, {});
    bool any = false;
    for (int y = 0; y < kCamera.height; ++y) {
      for (int x = 0; x < kCamera.width; ++x) {
        const std::optional<bool> meets = Meets(kCamera.CamFromImage({x + 0.5, y + 0.5}), corners);
        if (!meets) continue;
        ASSERT_EQ(seen.triangle[seen.Index(x, y)] == 0, *meets) << turn << ": " << x << ", " << y;
        any = any || *meets;
      }
    }
    const auto [low, high] = std::minmax({corners[0].z, corners[1].z, corners[2].z});
    seen_and_crossing += any && low < 0 && high > 0 ? 1 : 0;
  }
  EXPECT_GT(seen_and_crossing, 50);
}

// In a room, many triangles pass the camera beside the picture; each once took as long as one that
// fills it.
TEST(SeenTriangles, OnesThatPassBesideThePictureTakeNoTime) {
  const Camera large{2000, 1500, 1500.0, 1500.0, 1000.0, 750.0};
  TriangleMesh mesh;
  for (uint32_t i = 0; i < 3000; ++i) {
    const float y = 0.01f * float(i % 50) - 0.25f;
    mesh.positions.insert(mesh.positions.end(),
                          {{1, y, -0.1f}, {1, y + 0.01f, 0.1f}, {1, y, 0.1f}});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const Timer timer;
  const SeenTriangles seen = FindSeenTriangles(mesh, large, {});
  // The whole picture for each would be 9e9 pixels.
  EXPECT_LT(timer.seconds(), 2.0);
  EXPECT_TRUE(std::ranges::all_of(seen.triangle, [](uint32_t t) { return t == kNoTriangle; }));
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
