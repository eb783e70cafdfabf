#include "surface/texture_layout.h"

#include "core/error.h"
#include "expect_error.h"
#include "surface/shapes.h"
#include "surface/textured_shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numeric>

namespace tetrec {
namespace {

TriangleMesh RoughTorus() {
  const TetMesh mesh = JitteredBox(16);
  return AsTriangles(MarchTetrahedra(mesh, Sampled(mesh, Torus), 0));
}

double SideOf(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& p) {
  return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
}

// How many triangles contain each point of a grid that is finer than the texels.
int MostOnOnePoint(const TextureLayout& layout) {
  constexpr int kFiner = 3;
  const int size = kFiner * layout.size;
  std::vector<uint8_t> count(size_t(size) * size_t(size), 0);
  for (const auto& t : layout.corners) {
    const glm::dvec2 low = glm::min(t[0], glm::min(t[1], t[2])) * double(kFiner),
                     high = glm::max(t[0], glm::max(t[1], t[2])) * double(kFiner);
    for (int y = int(low.y); y <= std::min(size - 1, int(high.y)); ++y) {
      for (int x = int(low.x); x <= std::min(size - 1, int(high.x)); ++x) {
        const glm::dvec2 p((x + 0.4142) / kFiner, (y + 0.5772) / kFiner);
        // y points down, so triangles are clockwise here.
        const double inside = -1e-9;
        if (SideOf(t[0], t[1], p) < inside && SideOf(t[1], t[2], p) < inside &&
            SideOf(t[2], t[0], p) < inside) {
          ++count[size_t(y) * size_t(size) + size_t(x)];
        }
      }
    }
  }
  return *std::max_element(count.begin(), count.end());
}

TEST(TextureCharts, EachTriangleIsInOneChartAndFacesItsPlane) {
  const TriangleMesh mesh = RoughTorus();
  const std::vector<TextureChart> charts = CutIntoCharts(mesh);
  std::vector<int> times(mesh.triangles.size(), 0);
  for (const TextureChart& chart : charts) {
    EXPECT_NEAR(glm::dot(chart.x, chart.y), 0, 1e-12);
    for (const uint32_t t : chart.triangles) {
      ++times[t];
      const glm::uvec3& ids = mesh.triangles[t];
      EXPECT_GT(SideOf(chart.InPlane(mesh.positions[ids.x]), chart.InPlane(mesh.positions[ids.y]),
                       chart.InPlane(mesh.positions[ids.z])),
                0)
          << "triangle " << t;
    }
  }
  EXPECT_EQ(std::count(times.begin(), times.end(), 1), long(times.size()));
  // A torus needs a few; one for each triangle would be useless.
  EXPECT_LT(charts.size(), mesh.triangles.size() / 20);
}

TEST(TextureCharts, ACubeIsCutIntoAFewAndTrianglesWithoutAreaDoNoHarm) {
  TriangleMesh cube = GreyCube();
  const size_t charts = CutIntoCharts(cube).size();
  EXPECT_GE(charts, 2);
  EXPECT_LE(charts, 6);
  cube.triangles.emplace_back(0, 0, 1);
  cube.triangles.emplace_back(0, 0, 0);
  size_t triangles = 0;
  for (const TextureChart& chart : CutIntoCharts(cube)) triangles += chart.triangles.size();
  EXPECT_EQ(triangles, cube.triangles.size());
  EXPECT_TRUE(CutIntoCharts({}).empty());
}

TEST(TextureLayout, TrianglesDoNotOverlapAndStayInside) {
  const TriangleMesh mesh = RoughTorus();
  const TextureLayout layout = LayOutTextureOfSize(mesh, CutIntoCharts(mesh), 256);
  EXPECT_EQ(layout.size, 256);
  ASSERT_EQ(layout.corners.size(), mesh.triangles.size());
  double area = 0;
  for (size_t t = 0; t < layout.corners.size(); ++t) {
    for (const glm::dvec2& p : layout.corners[t]) {
      ASSERT_TRUE(p.x >= kTexturePadding && p.x <= 256 - kTexturePadding &&
                  p.y >= kTexturePadding && p.y <= 256 - kTexturePadding)
          << p.x << ", " << p.y;
    }
    area -= 0.5 * SideOf(layout.corners[t][0], layout.corners[t][1], layout.corners[t][2]);
  }
  EXPECT_GT(area, 0.4 * 256 * 256);  // the room is used
  EXPECT_EQ(MostOnOnePoint(layout), 1);
}

TEST(TextureLayout, TheSmallestSquareThatFitsIsTaken) {
  const TriangleMesh cube = GreyCube();  // of 6 sides, 2 wide
  const std::vector<TextureChart> charts = CutIntoCharts(cube);
  for (const double texel_size : {0.02, 0.005, 0.001}) {
    const TextureLayout layout = LayOutTexture(cube, charts, texel_size, 1024);
    if (layout.size < 1024) {
      EXPECT_LE(layout.texel_size, texel_size);
    }
    EXPECT_GT(24 / (texel_size * texel_size), 0.12 * layout.size * layout.size);
  }
  EXPECT_EQ(LayOutTexture(cube, charts, 0.001, 1024).size, 1024);
}

TEST(TextureLayout, TooManyChartsForASmallTextureAreRefused) {
  TriangleMesh confetti;
  for (int i = 0; i < 400; ++i) {
    const float x = float(i);
    for (const glm::vec3& p : {glm::vec3(x, 0, 0), glm::vec3(x + 0.5f, 0, 0), glm::vec3(x, 1, 0)}) {
      confetti.positions.push_back(p);
    }
    confetti.triangles.emplace_back(3 * i, 3 * i + 1, 3 * i + 2);
  }
  ExpectError<UsageError>([&] { LayOutTextureOfSize(confetti, CutIntoCharts(confetti), 64); },
                          {"texture is 64"});
}

}  // namespace
}  // namespace tetrec
