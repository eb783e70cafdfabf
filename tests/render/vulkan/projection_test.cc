// Projected tets against the reference renderer and the march.
#include "core/log.h"
#include "render/reference_loss.h"
#include "render/scenes.h"
#include "render/targets.h"
#include "render/vulkan/visibility_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace tetrec::test {
namespace {

const RendererOptions kProjection{.kind = RendererKind::kProjection};

double LargestDifference(const RenderedImage& image, const ReferenceImage& truth) {
  double largest = 0;
  for (size_t i = 0; i < truth.color_srgb.size(); ++i) {
    largest =
        std::max({largest, glm::distance(glm::dvec3(image.color_srgb[i]), truth.color_srgb[i]),
                  std::abs(double(image.transmittance[i]) - std::exp(-truth.optical_depth[i]))});
  }
  return largest;
}

// The largest difference divided by the largest value, for colours and densities.
double GradientError(const FieldGradient& gradient, const ReferenceGradient& truth) {
  double difference[2] = {}, largest[2] = {};
  for (size_t v = 0; v < truth.density.size(); ++v) {
    for (int i = 0; i < 3; ++i) {
      const double color = truth.color_srgb[v][i];
      difference[0] = std::max(difference[0], std::abs(gradient.color_srgb[v][i] - color));
      largest[0] = std::max(largest[0], std::abs(color));
    }
    difference[1] = std::max(difference[1], std::abs(gradient.density[v] - truth.density[v]));
    largest[1] = std::max(largest[1], std::abs(truth.density[v]));
  }
  return std::max(difference[0] / largest[0], difference[1] / largest[1]);
}

bool SameBits(const RenderedImage& a, const RenderedImage& b) {
  return a.color_srgb == b.color_srgb && a.transmittance == b.transmittance;
}

TEST_F(RendererTest, ProjectionInLittleMemoryShowsTheSameBitsAndGradients) {
  const RadianceField field = RandomField(300, 5, 10.0f);
  ProbedRenderer& ample = MakeRenderer(kProjection);
  ample.SetField(field);
  // 1 byte: one tet after another; 20 kB: about a thousand items at a time.
  for (uint64_t bytes : {1ull, 20'000ull}) {
    RendererOptions options = kProjection;
    options.fragment_memory = bytes;
    ProbedRenderer& little = MakeRenderer(options);
    little.SetField(field);
    for (const RenderView& view : ThreeViews(37, 27)) {
      EXPECT_TRUE(SameBits(little.Render(view, 2), ample.Render(view, 2))) << bytes;
      const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 3);
      const FieldGradient gradient =
          little.Backpropagate(view, std::vector<glm::vec4>(g.begin(), g.end()));
      EXPECT_LT(GradientError(gradient, BackpropagateReference(field, view, g, 1e-3f)),
                kGradientTolerance);
    }
  }
}

double LargestDifference(const RenderedImage& a, const RenderedImage& b) {
  double largest = 0;
  for (size_t i = 0; i < a.color_srgb.size(); ++i) {
    largest = std::max({largest, double(glm::distance(a.color_srgb[i], b.color_srgb[i])),
                        std::abs(double(a.transmittance[i]) - b.transmittance[i])});
  }
  return largest;
}

// The convex hull of random points: no five of them on a sphere, unlike the corners of a box.
RadianceField HullField(int points, uint32_t seed) {
  RadianceField field = RandomField(points, seed, 10.0f);
  std::vector<glm::vec3> inner(field.mesh.positions);
  std::erase_if(inner, [](const glm::vec3& p) {
    return p.x == kBoxMin.x || p.x == kBoxMax.x;  // the corners
  });
  const DelaunayResult delaunay = BuildDelaunay(inner);
  field.mesh = delaunay.mesh;
  field.density.resize(inner.size());
  field.color_srgb.resize(inner.size());
  return field;
}

TEST_F(RendererTest, ExactOrderShowsTheMarchsPictureAndCentroidOrderErrs) {
  const RadianceField field = HullField(300, 21);
  ASSERT_EQ(MeasurePowerOrder(field.mesh).tied_faces.size(), 0u);
  ProbedRenderer& march = MakeRenderer();
  ProbedRenderer& exact = MakeRenderer(kProjection);
  RendererOptions options = kProjection;
  options.order = VisibilityOrder::kCentroid;
  ProbedRenderer& centroid = MakeRenderer(options);
  for (ProbedRenderer* renderer : {&march, &exact, &centroid}) renderer->SetField(field);
  double centroid_error = 0;
  for (const RenderView& view : ThreeViews(60, 44)) {
    const RenderedImage truth = march.Render(view, 1);
    // Both have rounding errors.
    EXPECT_LT(LargestDifference(exact.Render(view, 1), truth), 2 * kPictureTolerance);
    EXPECT_LT(LargestDifference(exact.Render(view, 1), RenderReference(field, view, 1e-3)),
              kPictureTolerance);
    centroid_error = std::max(centroid_error, LargestDifference(centroid.Render(view, 1), truth));
  }
  RecordProperty("largest_error_of_centroid_order", std::to_string(centroid_error));
  LogInfo("centroid order: largest error of a colour {:.3f}", centroid_error);
  EXPECT_GT(centroid_error, 100 * kPictureTolerance);
}

// A mesh whose inner vertices were moved by less than would invert a tet: it is no longer Delaunay.
RadianceField MovedField(int points, uint32_t seed) {
  RadianceField field = RandomField(points, seed, 10.0f);
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  const auto is_valid = [&](uint32_t moved) {
    for (const glm::uvec4& tet : field.mesh.tets) {
      if (tet.x != moved && tet.y != moved && tet.z != moved && tet.w != moved) continue;
      const auto at = [&](int i) { return glm::dvec3(field.mesh.positions[tet[i]]); };
      if (glm::dot(glm::cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0)) < 1e-7) return false;
    }
    return true;
  };
  for (uint32_t v = 0; v < field.mesh.positions.size(); ++v) {
    glm::vec3& p = field.mesh.positions[v];
    const glm::vec3 before = p;
    const bool is_inner =
        glm::all(glm::greaterThan(p, kBoxMin)) && glm::all(glm::lessThan(p, kBoxMax));
    if (!is_inner) continue;
    p += 0.03f * glm::vec3(normal(random), normal(random), normal(random));
    if (!is_valid(v)) p = before;
  }
  return field;
}

TEST_F(RendererTest, TetsThatAreNotDelaunayAreSortedByWhatCoversWhat) {
  const RadianceField field = MovedField(300, 31);
  CheckTetMesh(field.mesh);
  EXPECT_GT(MeasurePowerOrder(field.mesh).bad_faces, 10u);
  ProbedRenderer& renderer = MakeRenderer(kProjection);
  renderer.SetField(field);
  for (const RenderView& view : ThreeViews(37, 27)) {
    EXPECT_LT(LargestDifference(renderer.Render(view, 1), RenderReference(field, view, 1e-3)),
              kPictureTolerance);
    const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 4);
    const FieldGradient gradient =
        renderer.Backpropagate(view, std::vector<glm::vec4>(g.begin(), g.end()));
    EXPECT_LT(GradientError(gradient, BackpropagateReference(field, view, g, 1e-3)),
              kGradientTolerance);
  }
}

// Rays exactly through vertices and along edges and faces: every one is covered exactly once.
TEST_F(RendererTest, RaysThroughVerticesAndEdgesPassProjectedTetsOnce) {
  std::vector<glm::vec3> lattice;
  for (int i = 0; i < 125; ++i) {
    lattice.push_back(0.25f * glm::vec3(i % 5, i / 5 % 5, i / 25));
  }
  const RadianceField field = ConstantField(BuildDelaunay(lattice).mesh, 1.0f, glm::vec3(0.5f));
  ProbedRenderer& renderer = MakeRenderer(kProjection);
  renderer.SetField(field);
  // Pixel centres of the middle cross are on the lattice's planes; the axes of all three cameras
  // are along rows of vertices.
  for (const glm::dvec3& eye : {glm::dvec3(0.5, 0.5, -2.0), glm::dvec3(3.0, 0.5, 0.5),
                                glm::dvec3(-1.5, -1.5, -1.5), glm::dvec3(0.5, 0.5, 0.25)}) {
    const RenderView view = LookAt(eye, glm::dvec3(0.5), 33, 33);
    const RenderedImage image = renderer.Render(view, 1);
    for (int i = 0; i < 33 * 33; ++i) {
      // The box (0, 0, 0) .. (1, 1, 1).
      const glm::dvec3 direction = PixelDirection(view, i % 33, i / 33);
      double begin = 0, end = 1e300;
      for (int axis = 0; axis < 3; ++axis) {
        const double at = direction[axis] == 0.0 ? 1e-300 : direction[axis];
        const double low = -eye[axis] / at, high = (1.0 - eye[axis]) / at;
        begin = std::max(begin, std::min(low, high));
        end = std::min(end, std::max(low, high));
      }
      if (std::abs(end - begin) < 1e-4) continue;  // along the edge
      EXPECT_NEAR(image.transmittance[i], std::exp(-std::max(0.0, end - begin)), 1e-5)
          << "eye " << eye.x << ", pixel " << i;
    }
  }
}

TEST(VisibilityOrder, PowerAndRanksPutTheNearerOfTwoNeighboursFirst) {
  // The four corners of a side of the box are on a circle: a tie with every vertex above it.
  const TetMesh mesh = RandomBoxMesh(200, 41);
  const PowerOrder power = MeasurePowerOrder(mesh);
  EXPECT_EQ(power.bad_faces, 0u);
  EXPECT_EQ(power.tied_faces.size(), 6u);
  for (const glm::vec3& eye : {glm::vec3(2.0f, 1.0f, 3.0f), glm::vec3(0.1f, 0.4f, 0.5f)}) {
    const VisibilityRanks ranks = RankByVisibility(mesh, eye);
    EXPECT_EQ(ranks.tets_in_cycles, 0u);
    const std::vector<uint32_t> tie_ranks = RankTies(mesh, power, eye).ranks;
    const auto key = [&](uint32_t t) {
      const double by_power = power.spheres[t].w - 2.0 * glm::dot(glm::dvec3(power.spheres[t]),
                                                                  glm::dvec3(eye) - power.origin);
      return std::pair(by_power, tie_ranks[t]);
    };
    for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
      for (int face = 0; face < 4; ++face) {
        const uint32_t neighbor = mesh.neighbors[t][face];
        if (neighbor == kNoTet) continue;
        // If the eye and the tet's fourth vertex are on one side of the face, the tet is in front.
        const auto at = [&](int i) { return glm::dvec3(mesh.positions[mesh.tets[t][i]]); };
        const glm::dvec3 a = at((face + 1) % 4), b = at((face + 2) % 4), c = at((face + 3) % 4);
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        const bool in_front =
            glm::dot(normal, glm::dvec3(eye) - a) * glm::dot(normal, at(face) - a) > 0.0;
        EXPECT_EQ(ranks.ranks[t] < ranks.ranks[neighbor], in_front);
        EXPECT_EQ(key(t) < key(neighbor), in_front);
      }
    }
  }
}

TEST(VisibilityOrder, TiesOfALatticeAreBrokenByWhatCoversWhat) {
  std::vector<glm::vec3> lattice;
  for (int i = 0; i < 64; ++i) lattice.emplace_back(i % 4, i / 4 % 4, i / 16);
  const TetMesh mesh = BuildDelaunay(lattice).mesh;
  const PowerOrder power = MeasurePowerOrder(mesh);
  EXPECT_EQ(power.bad_faces, 0u);
  const glm::vec3 eye(0.3f, 1.4f, -2.0f);
  const std::vector<uint32_t> ranks = RankTies(mesh, power, eye).ranks;
  ASSERT_EQ(ranks.size(), mesh.tets.size());
  EXPECT_GT(power.tied_faces.size(), 27u);  // each cube has inner faces
  for (const InnerFace& face : power.tied_faces) {
    EXPECT_EQ(power.spheres[face.tet], power.spheres[face.neighbor]);
    EXPECT_NE(ranks[face.tet], ranks[face.neighbor]);
  }
}

TEST(VisibilityOrder, CyclesAreCountedAndEveryTetIsRankedOnce) {
  // The same tet three times, with links that no real mesh has: seen from beyond the last face, tet
  // 0 covers 1, 1 covers 2 and 2 covers 0.
  TetMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  mesh.tets.assign(3, {0, 1, 2, 3});
  mesh.neighbors = {
      {1, kNoTet, kNoTet, 2}, {2, kNoTet, kNoTet, kNoTet}, {kNoTet, kNoTet, kNoTet, kNoTet}};
  const glm::vec3 eye(0.1f, 0.1f, -1.0f);
  PowerOrder ties;
  ties.tied_faces = {{0, 0, 1}, {1, 0, 2}, {0, 3, 2}};
  VisibilityRanks ranks = RankByVisibility(mesh, eye);
  EXPECT_EQ(ranks.tets_in_cycles, 1u);
  EXPECT_EQ(RankTies(mesh, ties, eye).tets_in_cycles, 1u);
  EXPECT_EQ(RankTies(mesh, ties, eye).ranks, ranks.ranks);
  std::sort(ranks.ranks.begin(), ranks.ranks.end());
  EXPECT_EQ(ranks.ranks, (std::vector<uint32_t>{0, 1, 2}));
}

// A step's rays are the same for every renderer, jitter included, and so is the result.
TEST_F(RendererTest, StepsOverProjectedTetsLowerTheLossAsTheMarchDoes) {
  const RadianceField truth = RandomField(40, 51, 6.0f);
  const std::vector<RenderView> views = ThreeViews(20, 14);
  std::vector<std::vector<double>> losses;
  for (RendererKind kind : {RendererKind::kMarch, RendererKind::kProjection}) {
    ProbedRenderer& renderer = MakeRenderer({.kind = kind});
    EXPECT_EQ(renderer.NeedsTiles(), kind == RendererKind::kProjection);
    renderer.SetField(truth);
    std::vector<TargetImage> targets;
    for (const RenderView& view : views) targets.push_back(TargetOf(renderer.Render(view, 1)));
    renderer.SetTargets(views, targets);
    renderer.SetField(ConstantField(truth.mesh, 0.2f, glm::vec3(0.5f)));
    losses.push_back(LearnPictures(renderer, views, 90, 1.0f));
  }
  EXPECT_LT(losses[1].back(), 0.2 * losses[1][2]);
  // Adam divides gradients by their own size, which magnifies the rounding of small ones.
  for (size_t i = 0; i < 10; ++i) EXPECT_NEAR(losses[1][i], losses[0][i], 1e-4 * losses[0][2]);
}

}  // namespace
}  // namespace tetrec::test
