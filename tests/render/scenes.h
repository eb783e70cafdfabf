// Small fields and cameras for the renderers' tests.
#pragma once

#include "core/error.h"
#include "geometry/look_at.h"
#include "mesh/delaunay.h"
#include "render/create_renderer.h"
#include "render/ray_blocks.h"
#include "render/training_renderer.h"

#include <glm/glm.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace tetrec::test {

// Corners of the box that every field here fills; exact floats, all sides different.
inline const glm::vec3 kBoxMin(-0.5f, -0.25f, 0.25f), kBoxMax(0.5f, 1.0f, 1.0f);

// 0 .. 7 -> corner of the box.
inline glm::vec3 BoxCorner(int i) {
  return {(i & 1) ? kBoxMax.x : kBoxMin.x, (i & 2) ? kBoxMax.y : kBoxMin.y,
          (i & 4) ? kBoxMax.z : kBoxMin.z};
}

// Delaunay mesh of the box's corners and `points` random points strictly inside.
inline TetMesh RandomBoxMesh(int points, uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.001f, 0.999f);
  std::vector<glm::vec3> all;
  for (int i = 0; i < 8; ++i) all.push_back(BoxCorner(i));
  for (int i = 0; i < points; ++i) {
    const glm::vec3 share(unit(random), unit(random), unit(random));
    all.push_back(kBoxMin + share * (kBoxMax - kBoxMin));
  }
  return BuildDelaunay(all).mesh;
}

// Random colours in [0, 1]; densities uniform in [0, max_density], some of them tiny.
inline RadianceField RandomField(int points, uint32_t seed, float max_density,
                                 FieldStorage storage = FieldStorage::kVertex) {
  RadianceField field;
  field.mesh = RandomBoxMesh(points, seed);
  field.storage = storage;
  std::mt19937 random(seed + 1);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (size_t row = 0; row < RowCount(field.mesh, storage); ++row) {
    const bool almost_empty = unit(random) < 0.2f;
    field.density.push_back(max_density * unit(random) * (almost_empty ? 1e-4f : 1.0f));
    field.color_srgb.emplace_back(unit(random), unit(random), unit(random));
  }
  return field;
}

// The field with a third of its values of density below 0, some of them by little.
inline RadianceField WithAnySign(RadianceField field, uint32_t seed) {
  std::mt19937 random(seed);
  for (float& density : field.density) {
    if (random() % 3 == 0) density *= random() % 2 == 0 ? -1.0f : -0.05f;
  }
  return field;
}

inline RadianceField ConstantField(TetMesh mesh, float density, const glm::vec3& color) {
  const size_t vertices = mesh.positions.size();
  return {std::move(mesh), std::vector<float>(vertices, density),
          std::vector<glm::vec3>(vertices, color)};
}

// How far pictures may be from those of the reference: in a ray's frame, vertices have an error of
// 2e-7 of the distance (3 here, with a box of size 1), so that errors of lengths are 1e-6;
// densities are up to 10, colours up to 1.
inline constexpr double kPictureTolerance = 2e-5;
// The same for gradients, relative to the largest. Hundreds of rays are added in float, in any
// order.
inline constexpr double kGradientTolerance = 3e-5;

// A camera at `eye` that looks at `target`; focal length in image widths.
inline RenderView LookAt(const glm::dvec3& eye, const glm::dvec3& target, int width, int height,
                         double focal = 1.0) {
  const glm::dvec3 forward = glm::normalize(target - eye);
  const glm::dvec3 up = std::abs(forward.y) < 0.9 ? glm::dvec3(0, -1, 0) : glm::dvec3(1, 0, 0);
  return {{width, height, focal * width, focal * width, 0.5 * width, 0.5 * height},
          CamLookingAt(eye, target, up)};
}

// One pixel whose ray runs from `eye` exactly (up to rounding) through `target`.
inline RenderView AimAt(const glm::dvec3& eye, const glm::dvec3& target) {
  return LookAt(eye, target, 1, 1);
}

// The ray's part ahead of `eye` inside the box.
struct BoxSpan {
  double length = 0.0;  // 0 if the ray misses
  double steepness =
      1.0;  // smallest |cosine| between the ray and the normals where it crosses the box
};

inline BoxSpan BoxChord(const glm::dvec3& eye, const glm::dvec3& direction) {
  double begin = 0.0, end = 1e300, begin_steepness = 1.0, end_steepness = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double along = direction[axis], steepness = std::abs(along);
    if (along == 0.0) {
      if (eye[axis] <= kBoxMin[axis] || eye[axis] >= kBoxMax[axis]) return {};
      continue;
    }
    const double low = (kBoxMin[axis] - eye[axis]) / along,
                 high = (kBoxMax[axis] - eye[axis]) / along;
    if (std::min(low, high) > begin) begin = std::min(low, high), begin_steepness = steepness;
    if (std::max(low, high) < end) end = std::max(low, high), end_steepness = steepness;
  }
  return {std::max(0.0, end - begin), std::min(begin_steepness, end_steepness)};
}

// Direction of the ray through the centre of a pixel, world frame, length 1.
inline glm::dvec3 PixelDirection(const RenderView& view, int x, int y) {
  return glm::normalize(view.cam_from_world.Inverse().rotation *
                        view.camera.CamFromImage({x + 0.5, y + 0.5}));
}

inline glm::dvec3 Eye(const RenderView& view) { return view.cam_from_world.Inverse().translation; }

// Every 4 x 2 block of an image, in row order.
inline std::vector<RayBlock> AllBlocks(const Camera& camera, uint32_t view = 0) {
  return CoveringBlocks(camera.width, camera.height, view);
}

// The blocks of one view after the other.
inline std::vector<RayBlock> BlocksOf(const std::vector<RenderView>& views) {
  std::vector<RayBlock> all;
  for (uint32_t v = 0; v < views.size(); ++v) {
    const auto blocks = AllBlocks(views[v].camera, v);
    all.insert(all.end(), blocks.begin(), blocks.end());
  }
  return all;
}

// Rows of the standard layout: rgb and the logarithm of density, or their moments.
inline std::vector<glm::vec4> StandardRows(const std::vector<float>& values) {
  std::vector<glm::vec4> rows(values.size() / kStandardComponents);
  for (size_t i = 0; i < values.size(); ++i) rows[i / 4][int(i % 4)] = values[i];
  return rows;
}

// Changes nothing but the moments.
inline const AdamUpdate kStandingUpdate{.color_rate = 0.0, .density_rate = 0.0};

// The losses that `steps` steps report, each on a whole image, the views in turn.
inline std::vector<double> LearnPictures(ProbedRenderer& renderer,
                                         const std::vector<RenderView>& views, uint32_t steps,
                                         float jitter_px = 0.0f) {
  std::vector<double> losses;
  for (uint32_t i = 1; i <= steps; ++i) {
    const uint32_t view = i % uint32_t(views.size());
    const std::vector<RayBlock> blocks = AllBlocks(views[view].camera, view);
    losses.push_back(renderer
                         .Step({.blocks = blocks,
                                .background_srgb = glm::vec3(i % 3 == 0, i % 2, 0.5f),
                                .jitter_px = jitter_px,
                                .seed = i},
                               {.step = i})
                         .loss);
  }
  return losses;
}

// Expects that a random state is read back bit by bit as it was set.
inline void ExpectStateComesBack(ProbedRenderer& renderer, const TetMesh& mesh,
                                 const FieldLayout& layout) {
  std::mt19937 random(1);
  std::normal_distribution<float> normal;
  const size_t values = RowCount(mesh, layout.storage) * size_t(layout.Components());
  FieldState state = WithoutMoments(layout, std::vector<float>(values));
  for (float& parameter : state.parameters) parameter = normal(random);
  for (float& moment : state.first_moment) moment = normal(random);
  for (float& moment : state.second_moment) moment = std::abs(normal(random));
  renderer.SetState(mesh, state);
  const FieldState back = renderer.ReadState();
  EXPECT_EQ(back.layout, layout);
  EXPECT_EQ(back.parameters, state.parameters);
  EXPECT_EQ(back.first_moment, state.first_moment);
  EXPECT_EQ(back.second_moment, state.second_moment);
}

// Owns renderers with validation on. A message of the layer fails the test that caused it.
class RendererTest : public ::testing::Test {
 protected:
  // Skips the test if there is no Vulkan device.
  ProbedRenderer& MakeRenderer(RendererOptions options = {}) {
    options.device.validation = true;
    renderers_.push_back(CreateProbedRenderer(options));
    return *renderers_.back();
  }

  void SetUp() override {
    try {
      MakeRenderer();
    } catch (const EnvironmentError& error) {
      GTEST_SKIP() << error.what();
    }
    renderers_.clear();
  }

  void TearDown() override {
    for (const auto& renderer : renderers_) {
      EXPECT_EQ(renderer->ValidationMessages(), std::vector<std::string>{});
    }
    // Messages from the destruction of renderers appear only in the log.
    ::testing::internal::CaptureStderr();
    renderers_.clear();
    EXPECT_EQ(::testing::internal::GetCapturedStderr().find("Vulkan validation"),
              std::string::npos);
  }

 private:
  std::vector<std::unique_ptr<ProbedRenderer>> renderers_;
};

// Compilers for GPUs fuse multiplications and additions, other ones in each kernel.
inline bool IsOfSoftware(const ProbedRenderer& renderer) {
  return renderer.DescribeDevice()["type"] == "software";
}

inline std::string NameOf(RendererKind kind) {
  return kind == RendererKind::kMarch        ? "March"
         : kind == RendererKind::kPpll       ? "Ppll"
         : kind == RendererKind::kProjection ? "Projection"
                                             : "Reference";
}

// Tests that every renderer must pass.
class EveryRendererTest : public RendererTest, public ::testing::WithParamInterface<RendererKind> {
 protected:
  ProbedRenderer& MakeRenderer(RendererOptions options = {}) {
    options.kind = GetParam();
    return RendererTest::MakeRenderer(options);
  }
};

inline const auto kEveryVulkanRenderer =
    ::testing::Values(RendererKind::kMarch, RendererKind::kPpll, RendererKind::kProjection);
inline const auto kEveryRenderer = ::testing::Values(
    RendererKind::kMarch, RendererKind::kPpll, RendererKind::kProjection, RendererKind::kReference);

inline std::string RendererName(const ::testing::TestParamInfo<RendererKind>& info) {
  return NameOf(info.param);
}

}  // namespace tetrec::test
