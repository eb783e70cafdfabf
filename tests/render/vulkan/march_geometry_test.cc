// With constant density a ray's optical depth is density times chord length: nothing may be lost or
// counted twice, wherever the ray meets the mesh.
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec::test {
namespace {

constexpr float kDensity = 1.5f;
// The error of float coordinates in the ray's frame is a few 2^-24 of the camera's distance, which
// is up to 6 here: 2e-6. That of a chord is larger if the ray enters or leaves at a flat angle.
double Tolerance(const BoxSpan& chord) { return 4e-6 / std::max(chord.steepness, 1e-3); }

// Slivers: points in four planes with a jitter of 1e-5, and pairs 1e-4 apart.
TetMesh SliverMesh() {
  std::mt19937 random(31);
  std::uniform_real_distribution<float> unit(0.05f, 0.95f), tiny(-1e-5f, 1e-5f);
  std::vector<glm::vec3> points;
  for (int i = 0; i < 8; ++i) points.push_back(BoxCorner(i));
  for (int i = 0; i < 400; ++i) {
    const glm::vec3 share(unit(random), unit(random), 0.2f * float(1 + i % 4) + tiny(random));
    points.push_back(kBoxMin + share * (kBoxMax - kBoxMin));
    if (i % 4 == 0) points.push_back(points.back() + 10.0f * glm::vec3(tiny(random)));
  }
  return BuildDelaunay(points).mesh;
}

bool OnHull(const glm::dvec3& p) {
  return glm::any(glm::equal(p, glm::dvec3(kBoxMin))) ||
         glm::any(glm::equal(p, glm::dvec3(kBoxMax)));
}

struct Ray {
  glm::dvec3 eye, target;
};

class ChordTest : public EveryRendererTest {
 protected:
  void SetMesh(const TetMesh& mesh) {
    renderer_ = &MakeRenderer({.stop_transmittance = 0.0f, .count_steps = true});
    renderer_->SetField(ConstantField(mesh, kDensity, glm::vec3(0.5f)));
  }

  void ExpectChord(const Ray& ray, double slack = 1.0) {
    const RenderView view = AimAt(ray.eye, ray.target);
    const RayBlock block{0, 0, 0};
    const double depth = renderer_->MarchBlocks(view, {&block, 1})[0].a;
    const BoxSpan chord = BoxChord(Eye(view), PixelDirection(view, 0, 0));
    EXPECT_NEAR(depth, kDensity * chord.length, slack * kDensity * Tolerance(chord))
        << "from " << ray.eye.x << " " << ray.eye.y << " " << ray.eye.z << " to " << ray.target.x
        << " " << ray.target.y << " " << ray.target.z;
  }

  void ExpectChordOfEveryPixel(const RenderView& view) {
    const RenderCounts before = renderer_->counts();
    const auto blocks = AllBlocks(view.camera);
    const auto rays = renderer_->MarchBlocks(view, blocks);
    uint64_t hits = 0, grazes = 0;
    for (size_t r = 0; r < rays.size(); ++r) {
      const int x = int(blocks[r / 8].x + r % 4), y = int(blocks[r / 8].y + r % 8 / 4);
      if (x >= view.camera.width || y >= view.camera.height) continue;
      const BoxSpan chord = BoxChord(Eye(view), PixelDirection(view, x, y));
      ASSERT_NEAR(rays[r].a, kDensity * chord.length, kDensity * Tolerance(chord))
          << "pixel " << x << ", " << y;
      hits += chord.length > 0.0;
      grazes += chord.length > 0.0 && chord.length < Tolerance(chord);
    }
    // For a ray that only grazes an edge of the box, rounding may decide either way.
    EXPECT_NEAR(double(renderer_->counts().hit_rays - before.hit_rays), double(hits),
                double(grazes));
  }

  void ExpectNothingLost() { EXPECT_EQ(renderer_->counts().lost_rays, 0u); }

  ProbedRenderer* renderer_ = nullptr;
};

INSTANTIATE_TEST_SUITE_P(Chords, ChordTest, kEveryRenderer, RendererName);

// Without the reference, which cuts every tet independently: if a ray is in the plane of a face up
// to rounding, both sides may claim a stretch, or neither.
using ChordOfVulkanTest = ChordTest;

INSTANTIATE_TEST_SUITE_P(Chords, ChordOfVulkanTest, kEveryVulkanRenderer, RendererName);

std::vector<RenderView> ViewsAllAround() {
  std::vector<RenderView> views;
  std::mt19937 random(32);
  std::uniform_real_distribution<double> around(-2.5, 3.0), inside(0.0, 1.0);
  const auto in_box = [&] {
    const glm::dvec3 share(inside(random), inside(random), inside(random));
    return glm::dvec3(kBoxMin) + share * glm::dvec3(kBoxMax - kBoxMin);
  };
  for (int i = 0; i < 12; ++i) {
    const glm::dvec3 eye =
        i % 2 == 0 ? in_box() : glm::dvec3(around(random), around(random), around(random));
    views.push_back(LookAt(eye, in_box(), 48, 40, 0.7));
  }
  return views;
}

TEST_P(ChordTest, HoldsForEveryPixelOfViewsFromOutsideAndInside) {
  for (int points : {0, 10, 200, 2000}) {
    SetMesh(RandomBoxMesh(points, 33));
    for (const RenderView& view : ViewsAllAround()) ExpectChordOfEveryPixel(view);
    ExpectNothingLost();
  }
}

TEST_P(ChordTest, HoldsInAMeshOfSlivers) {
  SetMesh(SliverMesh());
  for (const RenderView& view : ViewsAllAround()) ExpectChordOfEveryPixel(view);
  ExpectNothingLost();
}

TEST_P(ChordTest, HoldsThroughVerticesAndEdges) {
  const TetMesh mesh = RandomBoxMesh(60, 34);
  SetMesh(mesh);
  for (const glm::dvec3 eye : {glm::dvec3(1.7, -1.1, -1.0), glm::dvec3(0.125, 0.25, 0.5)}) {
    for (size_t v = 8; v < mesh.positions.size(); ++v)
      ExpectChord({eye, glm::dvec3(mesh.positions[v])});
    for (const glm::uvec4& tet : mesh.tets) {
      const glm::dvec3 a(mesh.positions[tet[0]]), b(mesh.positions[tet[3]]);
      ExpectChord({eye, 0.5 * (a + b)});
    }
  }
  ExpectNothingLost();
}

// Rounding of coordinates moves such an exit far along the ray, which must not count as a lost ray.
TEST_P(ChordTest, HoldsForRaysThatLeaveAtAFlatAngle) {
  SetMesh(RandomBoxMesh(60, 36));
  std::mt19937 random(37);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (const double slope : {2e-3, 5e-4, 1e-4}) {
    for (const double length : {0.001, 0.003, 0.03, 0.3}) {
      for (int i = 0; i < 4; ++i) {
        const glm::dvec3 entry(kBoxMin.x, glm::mix(kBoxMin.y, kBoxMax.y, 0.1 + 0.5 * unit(random)),
                               kBoxMax.z - slope * length);
        const glm::dvec3 way(1.0, 0.2 * unit(random), slope);
        ExpectChord({entry - 1.5 * way, entry + length * way});
      }
    }
  }
  ExpectNothingLost();
}
TEST_P(ChordTest, HoldsTowardsCornersAndEdgesOfTheBox) {
  SetMesh(RandomBoxMesh(60, 35));
  for (const glm::dvec3 eye : {glm::dvec3(1.7, -1.1, -1.0), glm::dvec3(0.125, 0.25, 0.5)}) {
    for (int i = 0; i < 8; ++i) {
      for (int j = 0; j <= i; ++j) {
        ExpectChord({eye, 0.5 * (glm::dvec3(BoxCorner(i)) + glm::dvec3(BoxCorner(j)))});
      }
    }
  }
  ExpectNothingLost();
}

// Straight along an edge of the mesh and in a face of it: both vertices of the edge are on one ray.
TEST_P(ChordOfVulkanTest, HoldsAlongEdgesOfTheMesh) {
  const TetMesh mesh = RandomBoxMesh(40, 36);
  SetMesh(mesh);
  // For triangles seen edge-on it is hardly defined where along them the ray passes.
  constexpr double kSlack = 10.0;
  for (const glm::uvec4& tet : mesh.tets) {
    const glm::dvec3 a(mesh.positions[tet[0]]), b(mesh.positions[tet[1]]),
        c(mesh.positions[tet[2]]);
    // Whether a ray in a face of the hull is inside or outside the box depends on rounding.
    if (OnHull(a) && OnHull(b)) continue;
    ExpectChord({a + 3.0 * (a - b) / glm::length(a - b), b}, kSlack);
    ExpectChord({b + 3.0 * (b - a) / glm::length(a - b), a}, kSlack);
    if (!OnHull(c)) ExpectChord({c + 3.0 * (c - 0.5 * (a + b)), 0.5 * (a + b)}, kSlack);
  }
  ExpectNothingLost();
}

TEST_P(ChordTest, HoldsForACameraInAVertexAnEdgeOrAFace) {
  const TetMesh mesh = RandomBoxMesh(40, 37);
  SetMesh(mesh);
  for (size_t t = 0; t < mesh.tets.size(); t += 7) {
    const glm::dvec3 a(mesh.positions[mesh.tets[t][0]]), b(mesh.positions[mesh.tets[t][1]]),
        c(mesh.positions[mesh.tets[t][2]]);
    for (const glm::dvec3& eye : {a, 0.5 * (a + b), (a + b + c) / 3.0}) {
      if (OnHull(eye)) continue;  // neither inside nor outside
      ExpectChordOfEveryPixel(LookAt(eye, {0.01, 0.3, 0.6}, 8, 8, 0.4));
    }
  }
  ExpectNothingLost();
}

TEST_P(ChordTest, HoldsInSmallAndLargeWorlds) {
  for (const float scale : {1e-3f, 1e3f}) {
    TetMesh mesh = RandomBoxMesh(100, 38);
    for (glm::vec3& p : mesh.positions) p *= scale;
    SetMesh(mesh);
    for (const RenderView& view : ViewsAllAround()) {
      RenderView scaled = view;
      scaled.cam_from_world.translation *= double(scale);
      const auto blocks = AllBlocks(view.camera);
      const auto rays = renderer_->MarchBlocks(scaled, blocks);
      for (size_t r = 0; r < rays.size(); ++r) {
        const int x = int(blocks[r / 8].x + r % 4), y = int(blocks[r / 8].y + r % 8 / 4);
        const BoxSpan chord = BoxChord(Eye(view), PixelDirection(view, x, y));
        ASSERT_NEAR(rays[r].a / (kDensity * scale), chord.length, Tolerance(chord));
      }
    }
    ExpectNothingLost();
  }
}

TEST_P(ChordTest, DensitiesFromNothingToOpaqueStayFinite) {
  for (float density : {0.0f, 1e-8f, 1.0f, 1e4f, 1e6f}) {
    for (float stop : {0.0f, 1e-3f}) {
      ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = stop});
      RadianceField field = ConstantField(RandomBoxMesh(300, 39), density, glm::vec3(0.3f));
      for (size_t v = 0; v < field.density.size(); v += 3) field.density[v] *= 0.01f;
      renderer.SetField(field);
      for (const RenderView& view : ViewsAllAround()) {
        for (const glm::vec4& ray : renderer.MarchBlocks(view, AllBlocks(view.camera))) {
          ASSERT_TRUE(std::isfinite(ray.r) && std::isfinite(ray.a)) << "density " << density;
          ASSERT_GE(ray.a, 0.0f);
          ASSERT_NEAR(ray.r, 0.3 * -std::expm1(-double(ray.a)), 2e-6 + 2e-6 * ray.r);
        }
        const FieldGradient gradient = renderer.Backpropagate(
            view, std::vector<glm::vec4>(48 * 40, glm::vec4(1.0f, 1.0f, 1.0f, -1.0f)));
        for (size_t v = 0; v < gradient.density.size(); ++v) {
          ASSERT_TRUE(std::isfinite(gradient.density[v]) && std::isfinite(gradient.color_srgb[v].g))
              << "density " << density << ", vertex " << v;
        }
      }
      EXPECT_EQ(renderer.counts().lost_rays, 0u);
    }
  }
}

}  // namespace
}  // namespace tetrec::test
