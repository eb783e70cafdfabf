#include "optimize/edge_gains.h"

#include "optimize/error_look.h"
#include "optimize/small_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace tetrec {
namespace {

TEST(GainOfStep, IsWhatTheParabolaLosesWithinBounds) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  EXPECT_DOUBLE_EQ(GainOfStep(3.0, 2.0, -kFar, kFar), 9.0 / 4.0);
  EXPECT_DOUBLE_EQ(GainOfStep(-3.0, 2.0, -kFar, kFar), 9.0 / 4.0);
  EXPECT_DOUBLE_EQ(GainOfStep(3.0, 2.0, -1.0, kFar), 3.0 - 1.0);
  EXPECT_DOUBLE_EQ(GainOfStep(3.0, 2.0, 0.0, kFar), 0.0);
  EXPECT_DOUBLE_EQ(GainOfStep(3.0, 0.0, -kFar, kFar), 0.0);
}

// The box of waves on a mesh that is too coarse for them.
RadianceField CoarseBox() {
  constexpr int kSide = 4;
  std::vector<glm::vec3> points;
  for (int i = 0; i < kSide * kSide * kSide; ++i) {
    const glm::ivec3 at(i % kSide, i / kSide % kSide, i / (kSide * kSide));
    glm::vec3 p = glm::vec3(at) * (2.0f / (kSide - 1)) - 1.0f;
    const bool is_inside = glm::all(glm::lessThan(glm::abs(p), glm::vec3(0.99f)));
    if (is_inside) p += 0.1f * glm::sin(glm::vec3(float(3 * i), float(5 * i), float(7 * i)));
    points.push_back(p);
  }
  RadianceField field;
  field.mesh = BuildDelaunay(points).mesh;
  for (const glm::vec3& p : field.mesh.positions) {
    field.density.push_back(2.0f + p.x);
    field.color_srgb.push_back(0.5f + 0.3f * glm::sin(3.0f * p + 2.0f * glm::vec3(p.y, p.z, p.x)));
  }
  return field;
}

// With a vertex in the middle of an edge, whose values are the edge's and `step`.
RadianceField WithVertex(const RadianceField& field, const glm::uvec2& edge,
                         const glm::dvec4& step) {
  RadianceField split = field;
  const auto mean = [&](const auto& values) { return 0.5f * (values[edge.x] + values[edge.y]); };
  const uint32_t middle = uint32_t(field.mesh.positions.size());
  split.mesh.positions.push_back(mean(field.mesh.positions));
  split.density.push_back(mean(field.density) + float(step.a));
  split.color_srgb.push_back(mean(field.color_srgb) + glm::vec3(step));
  split.mesh.tets.clear();
  for (const glm::uvec4& tet : field.mesh.tets) {
    const auto with_middle = [&](uint32_t end) {
      glm::uvec4 half = tet;
      for (int i = 0; i < 4; ++i) half[i] = tet[i] == end ? middle : tet[i];
      return half;
    };
    const glm::uvec4 first = with_middle(edge.x), second = with_middle(edge.y);
    if (first == tet || second == tet) {
      split.mesh.tets.push_back(tet);
    } else {
      split.mesh.tets.push_back(first);
      split.mesh.tets.push_back(second);
    }
  }
  split.mesh.neighbors = ComputeNeighbors(split.mesh.tets, split.mesh.positions.size());
  return split;
}

struct CoarseRun : SmallRun {
  CoarseRun() : SmallRun(Options(), 2, WavyBox(0.4, 2.0f)) {
    RadianceField box = field_of_run;
    const FieldState state = StateOf(box);
    field.Put(std::move(box.mesh), state);
    edges = EdgesOf(renderer->mesh());
    sums = LookAtEdges(*renderer, pictures.set(), batches, options, 0, edges);
    gains = GainsOfEdges(edges, state, sums);
  }
  static OptimizeOptions Options() {
    OptimizeOptions options = SmallRunOptions();
    options.background = BackgroundChoice::kScene;
    options.score_rays_per_tet = 1e6;  // all of them
    return options;
  }
  // Half the squared residual, summed over rays and channels.
  double LossOf(const RadianceField& other) {
    renderer->SetState(other.mesh, StateOf(other));
    TrainingBatch batch;
    const std::vector<RayBlock> blocks = pictures.set().blocks.List();
    batch.blocks = blocks;
    batch.background_srgb = batches.Background(0);
    return 1.5 * double(batch.rays()) * renderer->Forward(batch).squared_error;
  }

  RadianceField field_of_run = CoarseBox();
  MeshEdges edges;
  std::vector<EdgeSums> sums;
  std::vector<double> gains;
};

// Edges of all ranks, from the largest gain on.
std::vector<size_t> Sampled(const std::vector<double>& gains, size_t count) {
  std::vector<size_t> order(gains.size()), sampled;
  std::iota(order.begin(), order.end(), size_t{0});
  std::ranges::sort(order, [&](size_t a, size_t b) { return gains[a] > gains[b]; });
  for (size_t i = 0; i < count; ++i) sampled.push_back(order[i * order.size() / count]);
  return sampled;
}

// Spearman's coefficient of values that come in falling order of another quantity.
double RankCorrelation(const std::vector<double>& values) {
  const double count = double(values.size());
  double sum = 0.0;
  for (size_t i = 0; i < values.size(); ++i) {
    const auto above = std::ranges::count_if(values, [&](double v) { return v > values[i]; });
    sum += (double(i) - double(above)) * (double(i) - double(above));
  }
  return 1.0 - 6.0 * sum / (count * (count * count - 1.0));
}

TEST(EdgeSums, HaveTheSlopesOfAVertexInTheMiddle) {
  CoarseRun run;
  constexpr double kStep = 1e-2;
  for (const size_t e : Sampled(run.gains, 4)) {
    glm::dvec4 slopes;
    for (int c = 0; c < 4; ++c) {
      glm::dvec4 step(0.0);
      step[c] = kStep;
      const double above = run.LossOf(WithVertex(run.field_of_run, run.edges.ends[e], step));
      const double below = run.LossOf(WithVertex(run.field_of_run, run.edges.ends[e], -step));
      slopes[c] = (above - below) / (2.0 * kStep);
    }
    const EdgeSums& sums = run.sums[e];
    const double size = glm::length(glm::dvec3(slopes));
    EXPECT_NEAR(glm::distance(sums.color, glm::dvec3(slopes)), 0.0, 0.1 * size + 1e-2)
        << "edge " << e;
    EXPECT_NEAR(sums.density, slopes.a, 0.1 * std::abs(slopes.a) + 0.05) << "edge " << e;
  }
}

// A line search along the predicted step, with the vertex in place.
TEST(EdgeGains, RankTheEdgesByWhatALineSearchGains) {
  CoarseRun run;
  const double before = run.LossOf(run.field_of_run);
  std::vector<double> found;
  for (const size_t e : Sampled(run.gains, 14)) {
    const EdgeSums& sums = run.sums[e];
    const glm::dvec4 step(-sums.color / sums.color_curvature,
                          -sums.density / sums.density_curvature);
    double least = before;
    for (const double share : {0.25, 0.5, 1.0}) {
      least = std::min(least,
                       run.LossOf(WithVertex(run.field_of_run, run.edges.ends[e], share * step)));
    }
    found.push_back(before - least);
  }
  EXPECT_GT(RankCorrelation(found), 0.8);
}

}  // namespace
}  // namespace tetrec
