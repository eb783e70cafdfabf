// Gradients with respect to vertex positions: the reference against finite differences, every
// renderer against the reference, limits, and an inverse problem that they solve.
#include "render/reference_loss.h"
#include "render/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace tetrec::test {
namespace {

// One regular tet around `center`.
TetMesh OneTet(const glm::vec3& center, float edge) {
  const float half = edge / std::sqrt(8.0f);
  TetMesh mesh;
  for (const glm::vec3 corner :
       {glm::vec3(1, 1, 1), glm::vec3(1, -1, -1), glm::vec3(-1, 1, -1), glm::vec3(-1, -1, 1)}) {
    mesh.positions.push_back(center + half * corner);
  }
  mesh.tets = {{0, 1, 3, 2}};
  mesh.neighbors = {glm::uvec4(kNoTet)};
  CheckTetMesh(mesh);
  return mesh;
}

RadianceField ColorfulTet(const glm::vec3& center, float edge, float depth) {
  const float density = depth / edge;
  return {OneTet(center, edge),
          {0.6f * density, 1.0f * density, 1.4f * density, 0.8f * density},
          {{1.0f, 0.1f, 0.2f}, {0.2f, 0.9f, 0.1f}, {0.1f, 0.3f, 1.0f}, {0.9f, 0.8f, 0.3f}}};
}

double Norm(const std::vector<glm::dvec3>& values) {
  double sum = 0;
  for (const glm::dvec3& value : values) sum += glm::dot(value, value);
  return std::sqrt(sum);
}

// Errors over all vertices, relative to the norm.
struct PositionError {
  double position, absolute;
};

PositionError ErrorOf(const FieldGradient& gradient, const ReferenceGradient& truth) {
  std::vector<glm::dvec3> error;
  double absolute_error = 0, absolute = 0;
  for (size_t v = 0; v < truth.position.size(); ++v) {
    error.push_back(glm::dvec3(gradient.position[v]) - truth.position[v]);
    absolute_error += std::pow(gradient.absolute_position[v] - truth.absolute_position[v], 2);
    absolute += std::pow(truth.absolute_position[v], 2);
  }
  return {Norm(error) / Norm(truth.position), std::sqrt(absolute_error / absolute)};
}

// Every coordinate of every `stride`-th vertex.
void ExpectFiniteDifferences(RadianceField field, const RenderView& view, uint32_t seed,
                             size_t stride) {
  const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, seed);
  const ReferenceGradient gradient = BackpropagateReference(field, view, g, 0.0);
  double largest = 0;
  for (const glm::dvec3& p : gradient.position) largest = std::max(largest, glm::length(p));
  ASSERT_GT(largest, 0.0);
  for (size_t v = 0; v < field.density.size(); v += stride) {
    for (int axis = 0; axis < 3; ++axis) {
      // The loss is smooth except for second derivatives that jump when a ray meets an edge: a few
      // rays within a step of one have an error of a step's share (1e-5) of their gradient.
      EXPECT_NEAR(CentralDifference(field, field.mesh.positions[v][axis], 1e-5f, view, g),
                  gradient.position[v][axis], 1e-4 * largest)
          << "coordinate " << axis << " of vertex " << v << ", seed " << seed;
    }
  }
}

TEST(ReferenceRenderer, PositionGradientsAreFiniteDifferencesOfTheLossForOneTet) {
  for (float depth : {0.01f, 1.0f, 20.0f}) {
    const RadianceField field = ColorfulTet({0.05f, 0.35f, 0.6f}, 0.7f, depth);
    for (const RenderView& view : ThreeViews(12, 9)) ExpectFiniteDifferences(field, view, 61, 1);
  }
}

TEST(ReferenceRenderer, PositionGradientsAreFiniteDifferencesOfTheLoss) {
  struct Case {
    int points;
    float max_density;
    size_t stride;
  };
  // Thin and thick segments; the box's corners are the hull's vertices.
  for (const Case& c :
       {Case{0, 4.0f, 1}, Case{12, 8.0f, 1}, Case{12, 300.0f, 1}, Case{80, 20.0f, 4}}) {
    RadianceField field = RandomField(c.points, 62, c.max_density);
    for (const RenderView& view : ThreeViews(12, 9)) {
      ExpectFiniteDifferences(field, view, 63, c.stride);
    }
  }
}

// Moving field and camera together changes nothing, so the vertices' gradients add up to the
// reverse of the camera's, which is computed here by central differences.
TEST(ReferenceRenderer, PositionGradientsAddUpToThatOfTheCameraReversed) {
  const RadianceField field = RandomField(40, 64, 8.0f);
  for (const RenderView& view : ThreeViews(12, 9)) {
    const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 65);
    const ReferenceGradient gradient = BackpropagateReference(field, view, g, 0.0);
    glm::dvec3 sum(0.0);
    for (const glm::dvec3& p : gradient.position) sum += p;
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kStep = 1e-5;
      const auto moved = [&](double step) {
        glm::dvec3 shift(0.0);
        shift[axis] = step;
        RenderView other = view;
        other.cam_from_world.translation -= view.cam_from_world.rotation * shift;
        return Loss(field, other, g);
      };
      const double by_camera = (moved(kStep) - moved(-kStep)) / (2 * kStep);
      // The tolerance of the finite differences above.
      EXPECT_NEAR(sum[axis], -by_camera, 1e-4 * Norm(gradient.position)) << "axis " << axis;
    }
  }
}

TEST(ReferenceRenderer, InnerVerticesOfAConstantFieldHaveNoPositionGradient) {
  const RadianceField field = ConstantField(RandomBoxMesh(30, 64), 2.0f, glm::vec3(0.3f));
  for (const RenderView& view : ThreeViews(12, 9)) {
    const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 65);
    const ReferenceGradient gradient = BackpropagateReference(field, view, g, 0.0);
    for (size_t v = 0; v < field.density.size(); ++v) {
      const glm::vec3& p = field.mesh.positions[v];
      const bool on_hull = glm::any(glm::equal(p, kBoxMin)) || glm::any(glm::equal(p, kBoxMax));
      // The two sides of a face cancel up to the quadrature of the derivatives, 3e-6 of each.
      if (on_hull) continue;
      EXPECT_LT(glm::length(gradient.position[v]), 1e-5 * Norm(gradient.position));
    }
  }
}

TEST_P(EveryRendererTest, PositionGradientsAreThoseOfTheReferenceWithEitherKindOfAtomics) {
  struct Case {
    int points;
    float max_density;
    int width, height;
  };
  for (bool float_atomics : {true, false}) {
    for (float stop : {0.0f, 1e-3f}) {
      ProbedRenderer& renderer =
          MakeRenderer({.device = {.float_atomics = float_atomics}, .stop_transmittance = stop});
      for (const Case& c :
           {Case{0, 5.0f, 45, 33}, Case{20, 10.0f, 45, 33}, Case{20, 300.0f, 45, 33},
            Case{300, 10.0f, 37, 27}, Case{3000, 10.0f, 21, 15}}) {
        const RadianceField field = RandomField(c.points, 66, c.max_density);
        renderer.SetField(field);
        int number = 0;
        for (const RenderView& view : ThreeViews(c.width, c.height)) {
          SCOPED_TRACE(::testing::Message()
                       << c.points << " points, density " << c.max_density << ", stop " << stop
                       << ", atomics " << float_atomics << ", view " << number++);
          const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 67);
          const FieldGradient gradient =
              renderer.Backpropagate(view, std::vector<glm::vec4>(g.begin(), g.end()),
                                     GradientParts::kColorDensityPosition);
          const ReferenceGradient truth = BackpropagateReference(field, view, g, stop);
          const PositionError error = ErrorOf(gradient, truth);
          // The error of float coordinates is 1e-6 of the box's side; faces seen at a flat angle
          // and steep densities magnify it 30 times here.
          EXPECT_LE(error.position, 1e-4);
          EXPECT_LE(error.absolute, 1e-4);
        }
      }
    }
  }
}

TEST_P(EveryRendererTest, PositionGradientsOfEveryIntegralAreThoseOfTheReference) {
  for (const char* words : {"mean", "split:1", "split:4", "split:16"}) {
    for (int points : {20, 300}) {
      SCOPED_TRACE(::testing::Message() << words << ", " << points << " points");
      const RadianceField field = RandomField(points, 75, 40.0f);
      const IntegralOptions integral = ParseIntegral(words);
      ProbedRenderer& renderer = MakeRenderer({.integral = integral, .stop_transmittance = 0.0f});
      renderer.SetField(field);
      for (const RenderView& view : ThreeViews(21, 15)) {
        const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 76);
        const FieldGradient gradient = renderer.Backpropagate(
            view, std::vector<glm::vec4>(g.begin(), g.end()), GradientParts::kColorDensityPosition);
        const PositionError error =
            ErrorOf(gradient, BackpropagateReference(field, view, g, 0.0, integral));
        EXPECT_LE(error.position, 1e-4);
        EXPECT_LE(error.absolute, 1e-4);
      }
    }
  }
}

// A list of tets that does not fit is composited one part at a time: passages through tets continue
// from one part to the next.
TEST_F(RendererTest, PositionGradientsInLittleMemoryAreTheSame) {
  const RadianceField field = RandomField(300, 77, 10.0f);
  for (RendererKind kind : {RendererKind::kPpll, RendererKind::kProjection}) {
    for (uint64_t bytes : {2'000ull, 20'000ull}) {
      ProbedRenderer& renderer =
          MakeRenderer({.kind = kind, .stop_transmittance = 0.0f, .fragment_memory = bytes});
      renderer.SetField(field);
      for (const RenderView& view : ThreeViews(21, 15)) {
        const std::vector<glm::dvec4> g = RandomPixelGradient(view.camera, 78);
        const FieldGradient gradient = renderer.Backpropagate(
            view, std::vector<glm::vec4>(g.begin(), g.end()), GradientParts::kColorDensityPosition);
        const PositionError error = ErrorOf(gradient, BackpropagateReference(field, view, g, 0.0));
        EXPECT_LE(error.position, 1e-4) << NameOf(kind) << ", " << bytes << " bytes";
        EXPECT_LE(error.absolute, 1e-4) << NameOf(kind) << ", " << bytes << " bytes";
      }
    }
  }
}

TEST_P(EveryRendererTest, PositionGradientsCostTheOthersNothing) {
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetField(RandomField(100, 68, 10.0f));
  const RenderView view = ThreeViews(21, 15)[0];
  const std::vector<glm::vec4> g(21 * 15, glm::vec4(1.0f, -0.5f, 0.25f, 2.0f));
  const FieldGradient without = renderer.Backpropagate(view, g);
  EXPECT_TRUE(without.position.empty());
  EXPECT_TRUE(without.absolute_position.empty());
  // Requested twice: earlier sums must be gone.
  const auto with = [&] {
    return renderer.Backpropagate(view, g, GradientParts::kColorDensityPosition);
  };
  const FieldGradient first = with(), second = with();
  for (size_t v = 0; v < without.density.size(); ++v) {
    const float tolerance = 1e-5f * glm::length(first.position[v]) + 1e-4f;
    EXPECT_NEAR(glm::distance(first.position[v], second.position[v]), 0.0f, tolerance);
    EXPECT_NEAR(without.density[v], first.density[v], 1e-4f * std::abs(first.density[v]) + 1e-4f);
  }
}

// The gradient of one ray is its own absolute sum; with many rays, opposite ones cancel in one of
// the two only.
TEST_P(EveryRendererTest, AbsoluteSumsAreTheLengthsOfTheRaysOwnGradients) {
  const RadianceField field = RandomField(20, 69, 6.0f);
  ProbedRenderer& renderer = MakeRenderer();
  renderer.SetField(field);
  const RenderView view = LookAt({1.7, -1.1, -1.0}, {0.0, 0.3, 0.6}, 12, 9);
  std::vector<double> sums(field.density.size());
  for (int pixel = 0; pixel < 12 * 9; ++pixel) {
    std::vector<glm::vec4> g(12 * 9, glm::vec4(0.0f));
    g[pixel] = pixel % 2 == 0 ? glm::vec4(1.0f) : glm::vec4(-1.0f);
    const FieldGradient one = renderer.Backpropagate(view, g, GradientParts::kColorDensityPosition);
    const glm::dvec3 direction = PixelDirection(view, pixel % 12, pixel / 12);
    for (size_t v = 0; v < sums.size(); ++v) {
      const glm::dvec3 p(one.position[v]);
      const double across = glm::length(p - glm::dot(p, direction) * direction);
      // If a ray passes the tets around a vertex twice, its absolute sum may exceed the length of
      // its sum.
      EXPECT_GE(one.absolute_position[v], across * (1 - 1e-4) - 1e-5);
      sums[v] += one.absolute_position[v];
    }
  }
  std::vector<glm::vec4> g(12 * 9);
  for (int pixel = 0; pixel < 12 * 9; ++pixel) {
    g[pixel] = pixel % 2 == 0 ? glm::vec4(1.0f) : glm::vec4(-1.0f);
  }
  const FieldGradient all = renderer.Backpropagate(view, g, GradientParts::kColorDensityPosition);
  for (size_t v = 0; v < sums.size(); ++v) {
    EXPECT_NEAR(all.absolute_position[v], sums[v], 1e-5 * sums[v] + 1e-6);
  }
}

void ExpectFinite(const FieldGradient& gradient) {
  for (size_t v = 0; v < gradient.position.size(); ++v) {
    ASSERT_FALSE(glm::any(glm::isnan(gradient.position[v])) ||
                 glm::any(glm::isinf(gradient.position[v])))
        << "position " << v;
    ASSERT_TRUE(std::isfinite(gradient.absolute_position[v])) << "absolute " << v;
    ASSERT_TRUE(std::isfinite(gradient.density[v])) << "density " << v;
  }
}

TEST_P(EveryRendererTest, PositionGradientsStayFiniteInTheLimits) {
  // The points are on a lattice: many rays of a camera on it are in faces and pass vertices.
  std::vector<glm::vec3> lattice;
  for (int i = 0; i < 4 * 4 * 4; ++i) {
    lattice.push_back(0.25f * glm::vec3(i % 4, i / 4 % 4, i / 16));
  }
  const TetMesh grid = BuildDelaunay(lattice).mesh;
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  for (const TetMesh& mesh : {grid, RandomBoxMesh(60, 70), OneTet({0.2f, 0.3f, 0.4f}, 1e-3f)}) {
    for (float density : {0.0f, 1.0f, 1e6f}) {
      RadianceField field = ConstantField(mesh, density, glm::vec3(0.5f));
      for (size_t v = 0; v < field.density.size(); v += 3) {
        field.density[v] *= 0.01f;
        field.color_srgb[v] = glm::vec3(1.0f, 0.0f, 0.25f);
      }
      renderer.SetField(field);
      std::vector<glm::dvec3> eyes = {
          {0.25, 0.25, 0.25}, {0.25, 0.25, 3.0}, {-1.0, 0.5, 0.5}, {0.3, 0.25, 0.5}};
      for (size_t v = 0; v < mesh.positions.size(); v += 13) eyes.emplace_back(mesh.positions[v]);
      for (const glm::dvec3& eye : eyes) {
        // With odd sizes the middle ray is exactly along the axis.
        const RenderView view =
            LookAt(eye, eye + glm::dvec3(0.0, 0.0, eye.z > 1 ? -1.0 : 1.0), 9, 9);
        ExpectFinite(renderer.Backpropagate(view, std::vector<glm::vec4>(81, glm::vec4(1.0f)),
                                            GradientParts::kColorDensityPosition));
      }
    }
  }
}

// An inverse problem: find the vertices of a small tet with known colours from rays.
struct InverseProblem {
  static constexpr float kEdge = 0.02f;
  RadianceField truth = ColorfulTet({0.2f, 0.3f, 0.4f}, kEdge, 1.5f);
  std::vector<RenderView> views;  // 80 rays in total
  std::vector<ReferenceImage> targets;

  InverseProblem() {
    const glm::dvec3 center(0.2, 0.3, 0.4);
    for (const glm::dvec3 side : {glm::dvec3(1, 0.2, 0.1), glm::dvec3(-0.3, 1, 0.2),
                                  glm::dvec3(0.1, -0.4, 1), glm::dvec3(-0.5, -0.6, -0.7)}) {
      views.push_back(LookAt(center + 0.1 * glm::normalize(side), center, 5, 4, 4.0));
      targets.push_back(RenderReference(truth, views.back(), 0.0));
    }
  }

  // Loss of a field and its gradient with respect to positions.
  using Evaluate =
      std::function<double(const RadianceField&, std::vector<glm::dvec3>& position_gradient)>;

  // Half the squared residual of a pixel; adds dL/d(rgb, transmittance) to `g`.
  static double AddResidual(const glm::dvec4& pixel, const glm::dvec4& target,
                            std::vector<glm::dvec4>& g) {
    g.push_back(pixel - target);
    return 0.5 * glm::dot(g.back(), g.back());
  }
  glm::dvec4 Target(size_t view, size_t pixel) const {
    return {targets[view].color_srgb[pixel], std::exp(-targets[view].optical_depth[pixel])};
  }
};

struct Solution {
  double first_loss, last_loss, vertex_error;  // rms, in edges
};

// Adam on positions from a start that is off by a tenth of an edge.
Solution Solve(const InverseProblem& problem, uint32_t seed,
               const InverseProblem::Evaluate& evaluate) {
  RadianceField field = problem.truth;
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  for (glm::vec3& p : field.mesh.positions) {
    p += 0.06f * InverseProblem::kEdge * glm::vec3(normal(random), normal(random), normal(random));
  }
  std::vector<glm::dvec3> first(4, glm::dvec3(0.0)), second(4, glm::dvec3(0.0));
  constexpr int kSteps = 300;
  Solution solution{};
  for (int i = 1; i <= kSteps; ++i) {
    std::vector<glm::dvec3> gradient;
    const double loss = evaluate(field, gradient);
    if (i == 1) solution.first_loss = loss;
    solution.last_loss = loss;
    const double rate = 0.06 * InverseProblem::kEdge * std::pow(0.01, double(i) / kSteps);
    for (int v = 0; v < 4; ++v) {
      first[v] = 0.9 * first[v] + 0.1 * gradient[v];
      second[v] = 0.99 * second[v] + 0.01 * gradient[v] * gradient[v];
      const glm::dvec3 mean = first[v] / (1 - std::pow(0.9, i));
      const glm::dvec3 scale = glm::sqrt(second[v] / (1 - std::pow(0.99, i))) + 1e-12;
      field.mesh.positions[v] -= glm::vec3(rate * mean / scale);
    }
  }
  for (int v = 0; v < 4; ++v) {
    const glm::vec3 off = field.mesh.positions[v] - problem.truth.mesh.positions[v];
    solution.vertex_error += glm::dot(off, off) / 4 / std::pow(InverseProblem::kEdge, 2);
  }
  solution.vertex_error = std::sqrt(solution.vertex_error);
  return solution;
}

void ExpectSolved(const Solution& solution) {
  // Rates fall to 6e-4 of an edge; the remaining error is smaller.
  EXPECT_LT(solution.last_loss, 1e-5 * solution.first_loss);
  EXPECT_LT(solution.vertex_error, 6e-4);
}

TEST(ReferenceRenderer, VerticesOfASmallTetAreFoundFromRays) {
  const InverseProblem problem;
  for (uint32_t seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE(seed);
    ExpectSolved(Solve(
        problem, seed, [&](const RadianceField& field, std::vector<glm::dvec3>& position_gradient) {
          double loss = 0;
          position_gradient.assign(4, glm::dvec3(0.0));
          for (size_t i = 0; i < problem.views.size(); ++i) {
            const ReferenceImage image = RenderReference(field, problem.views[i], 0.0);
            std::vector<glm::dvec4> g;
            for (size_t pixel = 0; pixel < image.color_srgb.size(); ++pixel) {
              const glm::dvec4 value(image.color_srgb[pixel],
                                     std::exp(-image.optical_depth[pixel]));
              loss += problem.AddResidual(value, problem.Target(i, pixel), g);
            }
            const auto gradient = BackpropagateReference(field, problem.views[i], g, 0.0);
            for (int v = 0; v < 4; ++v) position_gradient[v] += gradient.position[v];
          }
          return loss;
        }));
  }
}

TEST_P(EveryRendererTest, VerticesOfASmallTetAreFoundFromRays) {
  const InverseProblem problem;
  ProbedRenderer& renderer = MakeRenderer({.stop_transmittance = 0.0f});
  for (uint32_t seed : {1u, 2u}) {
    SCOPED_TRACE(seed);
    ExpectSolved(Solve(
        problem, seed, [&](const RadianceField& field, std::vector<glm::dvec3>& position_gradient) {
          double loss = 0;
          position_gradient.assign(4, glm::dvec3(0.0));
          renderer.SetField(field);
          for (size_t i = 0; i < problem.views.size(); ++i) {
            const RenderedImage image = renderer.Render(problem.views[i], 1);
            std::vector<glm::dvec4> g;
            for (size_t pixel = 0; pixel < image.color_srgb.size(); ++pixel) {
              const glm::dvec4 value(image.color_srgb[pixel], image.transmittance[pixel]);
              loss += problem.AddResidual(value, problem.Target(i, pixel), g);
            }
            const FieldGradient gradient =
                renderer.Backpropagate(problem.views[i], std::vector<glm::vec4>(g.begin(), g.end()),
                                       GradientParts::kColorDensityPosition);
            for (int v = 0; v < 4; ++v) position_gradient[v] += glm::dvec3(gradient.position[v]);
          }
          return loss;
        }));
  }
}

}  // namespace
}  // namespace tetrec::test
