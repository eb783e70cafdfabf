// Colours that hardly any ray determines.
#include "optimize/weak_colors.h"

#include "core/random.h"
#include "mesh/mesh_edges.h"
#include "render/ray_blocks.h"

#include <algorithm>

namespace tetrec {
namespace {

// Gradients are squared part by part, so that few rays of a part share a vertex: parts for each
// pixel per vertex.
constexpr double kPartsPerPixelOfVertex = 3;
constexpr size_t kMostParts = 64;  // each takes a few batches at least, and reads all gradients
// With more than so many times kPriorEvidence, a colour stays: it would change by less than a
// hundredth of its distance to the neighbours.
constexpr double kStrong = 100;
constexpr double kLeastWeight = 1e-3;  // of a neighbour without evidence
constexpr int kSweeps = 30;

// Adds to `evidence` what the rays of one part say.
void AddEvidence(TrainingRenderer& renderer, std::span<const RayBlock> blocks,
                 const BatchDrawer& batches, std::vector<float>& evidence) {
  const uint64_t rays = blocks.size() * kRaysPerBlock;
  const size_t most = size_t(batches.rays_per_step()) / kRaysPerBlock;
  for (size_t first = 0, count = 0; first < blocks.size(); first += count) {
    count = batches.CountOfBatch(blocks.subspan(first), most);
    TrainingBatch batch;
    batch.blocks = blocks.subspan(first, count);
    batch.loss = LossKind::kL1;
    batch.background_srgb = batches.background_of_scene_srgb();
    batch.update_rays = rays;
    renderer.Forward(batch);
    renderer.Backward(GradientParts::kColorDensity);
  }
  const std::vector<double> gradients = renderer.TakeGradients().values;
  const size_t components = gradients.size() / evidence.size();
  // The loss is the mean over rays and channels.
  const double per_ray = 3.0 * double(rays);
  for (size_t vertex = 0; vertex < evidence.size(); ++vertex) {
    double squares = 0;
    for (size_t channel = 0; channel < 3; ++channel) {
      const double shares = per_ray * gradients[vertex * components + kColorOffset + channel];
      squares += shares * shares;
    }
    evidence[vertex] += float(squares / 3);
  }
}

// The neighbours of each vertex, and their weights.
struct Neighbours {
  std::vector<uint32_t> first;  // (V + 1) places in the others
  std::vector<uint32_t> vertices;
  std::vector<float> weights;
};

Neighbours NeighboursOf(const TetMesh& mesh, std::span<const float> evidence) {
  const std::vector<glm::uvec2> ends = EdgesOf(mesh).ends;
  Neighbours result;
  result.first.assign(mesh.positions.size() + 1, 0);
  for (const glm::uvec2& edge : ends) {
    ++result.first[edge.x + 1];
    ++result.first[edge.y + 1];
  }
  for (size_t i = 1; i < result.first.size(); ++i) result.first[i] += result.first[i - 1];
  result.vertices.resize(2 * ends.size());
  result.weights.resize(2 * ends.size());
  std::vector<uint32_t> next(result.first.begin(), result.first.end() - 1);
  const auto add = [&](uint32_t vertex, uint32_t neighbour) {
    const float length = glm::distance(mesh.positions[vertex], mesh.positions[neighbour]);
    const double known = evidence[neighbour] / (evidence[neighbour] + kPriorEvidence);
    result.vertices[next[vertex]] = neighbour;
    result.weights[next[vertex]++] = float((kLeastWeight + known) / std::max(length, 1e-9f));
  };
  for (const glm::uvec2& edge : ends) {
    add(edge.x, edge.y);
    add(edge.y, edge.x);
  }
  return result;
}

// The components of a row that are smoothed.
std::vector<int> SmoothedComponents(const FieldLayout& layout) {
  std::vector<int> result = {kColorOffset, kColorOffset + 1, kColorOffset + 2};
  const int count = 3 * HarmonicsCount(layout.HarmonicsDegree());
  for (int i = 0; i < count; ++i) result.push_back(layout.OffsetOf(kHarmonicsName) + i);
  return result;
}

}  // namespace

std::vector<float> LookAtColorEvidence(TrainingRenderer& renderer, const TrainingSet& set,
                                       const BatchDrawer& batches, uint64_t seed) {
  std::vector<RayBlock> blocks = LearnedBlocks(set);
  Random random(seed, 0xE71Dull);
  DrawInFront(std::span(blocks), blocks.size(), random);
  std::vector<float> evidence(renderer.mesh().positions.size(), 0.0f);
  renderer.TakeGradients();
  const double pixels = double(blocks.size() * kRaysPerBlock);
  const double pixels_of_vertex = pixels / double(std::max<size_t>(evidence.size(), 1));
  const size_t parts = std::min(kMostParts, 1 + size_t(kPartsPerPixelOfVertex * pixels_of_vertex));
  for (size_t part = 0; part < parts; ++part) {
    const size_t begin = blocks.size() * part / parts, end = blocks.size() * (part + 1) / parts;
    const std::span<RayBlock> some(blocks.begin() + begin, blocks.begin() + end);
    if (some.empty()) continue;
    SortByPlace(some);
    AddEvidence(renderer, some, batches, evidence);
  }
  return evidence;
}

void SmoothWeakColors(const TetMesh& mesh, std::span<const float> evidence, FieldState& state) {
  const Neighbours neighbours = NeighboursOf(mesh, evidence);
  const std::vector<int> smoothed = SmoothedComponents(state.layout);
  const size_t components = size_t(state.layout.Components());
  const std::vector<float> learned = state.parameters;
  std::vector<double> mean(smoothed.size());
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (size_t vertex = 0; vertex < evidence.size(); ++vertex) {
      if (evidence[vertex] > kStrong * kPriorEvidence) continue;
      std::ranges::fill(mean, 0.0);
      double weights = 0;
      for (uint32_t at = neighbours.first[vertex]; at < neighbours.first[vertex + 1]; ++at) {
        const float* row = &state.parameters[neighbours.vertices[at] * components];
        const double weight = neighbours.weights[at];
        for (size_t i = 0; i < smoothed.size(); ++i) mean[i] += weight * row[smoothed[i]];
        weights += weight;
      }
      if (!(weights > 0)) continue;
      const double own = evidence[vertex] / (evidence[vertex] + kPriorEvidence);
      for (size_t i = 0; i < smoothed.size(); ++i) {
        const size_t at = vertex * components + size_t(smoothed[i]);
        state.parameters[at] = float(own * learned[at] + (1 - own) * mean[i] / weights);
      }
    }
  }
}

}  // namespace tetrec
