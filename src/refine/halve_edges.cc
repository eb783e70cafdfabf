// Refinement in place: edges are halved, and vertices that are not needed are collapsed.
#include "refine/halve_edges.h"

#include "mesh/boundary.h"
#include "refine/collapse.h"
#include "refine/edited_mesh.h"

#include <algorithm>
#include <utility>

namespace tetrec {
namespace {

struct RankedEdge {
  double score;
  uint32_t a, b;
};

// Adds the edges from a vertex to those of higher ids that have a score.
void RankEdgesAt(const EditedMesh& mesh, uint32_t vertex, const std::vector<float>& scores,
                 std::vector<RankedEdge>& edges) {
  std::vector<std::pair<uint32_t, float>> parts;  // the other end, and the score of a tet
  for (const uint32_t t : mesh.TetsAt(vertex)) {
    for (int i = 0; i < 4; ++i) {
      if (mesh.tet(t)[i] > vertex) parts.emplace_back(mesh.tet(t)[i], scores[t]);
    }
  }
  std::ranges::sort(parts);
  for (size_t first = 0, end = 0; first < parts.size(); first = end) {
    const uint32_t other = parts[first].first;
    double sum = 0;
    for (; end < parts.size() && parts[end].first == other; ++end) sum += double(parts[end].second);
    if (!(sum > 0)) continue;
    const double length = double(glm::distance(mesh.position(vertex), mesh.position(other)));
    edges.push_back({length * sum / double(end - first), vertex, other});
  }
}

// The most urgent ones first.
std::vector<RankedEdge> RankEdges(const EditedMesh& mesh, const std::vector<float>& scores) {
  std::vector<RankedEdge> edges;
  for (uint32_t v = 0; v < mesh.vertices(); ++v) RankEdgesAt(mesh, v, scores, edges);
  std::ranges::stable_sort(edges, std::ranges::greater{}, &RankedEdge::score);
  return edges;
}

class Halving {
 public:
  Halving(EditedMesh mesh, std::vector<uint8_t> on_boundary, const RefineOptions& options)
      : options_(options),
        on_boundary_(std::move(on_boundary)),
        splits_(mesh.vertices(), 0),
        is_cut_(mesh.tets(), 0),
        mesh_(std::move(mesh)) {}

  void Halve(const std::vector<RankedEdge>& edges, uint64_t budget) {
    for (const auto& [score, a, b] : edges) {
      if (mesh_.vertices_left() >= budget) return;
      if (!MayHalve(a, b)) continue;
      const std::vector<uint32_t> around = mesh_.TetsAround(a, b);
      if (std::ranges::any_of(around, [&](uint32_t t) { return is_cut_[t]; })) continue;
      if (!mesh_.Halve(a, b, around)) {
        ++refused_;
        continue;
      }
      ++splits_[a];
      ++splits_[b];
      is_cut_.resize(mesh_.tets(), 1);
      for (const uint32_t t : around) is_cut_[t] = 1;
    }
  }

  Refinement Take() {
    Refinement result = mesh_.Take();
    result.refused = refused_;
    return result;
  }

 private:
  bool MayHalve(uint32_t a, uint32_t b) const {
    return !(on_boundary_[a] && on_boundary_[b]) &&
           std::max(splits_[a], splits_[b]) < options_.max_splits_at_vertex &&
           double(glm::distance(mesh_.position(a), mesh_.position(b))) >= options_.min_edge;
  }

  const RefineOptions& options_;
  std::vector<uint8_t> on_boundary_;  // of each vertex from before
  std::vector<int> splits_;           // at each vertex from before
  std::vector<uint8_t> is_cut_;       // of each tet
  EditedMesh mesh_;
  uint64_t refused_ = 0;
};

}  // namespace

Refinement HalveEdges(TetMesh mesh, const FieldState& state, const RefineScores& scores,
                      const RefineOptions& options) {
  const uint64_t budget = VertexBudget(mesh.positions.size(), options);
  const bool collapses = !scores.visible_of_tets.empty() &&
                         state.layout.storage == FieldStorage::kVertex &&
                         CountDegenerateTets(mesh) == 0;
  std::vector<uint8_t> on_boundary = BoundaryVertices(mesh);
  std::vector<uint8_t> stays = FixedVertices(mesh, scores);
  EditedMesh edited(std::move(mesh));
  Collapsed collapsed;
  if (collapses) collapsed = CollapseSpare(edited, std::move(stays), state, scores, options);
  const std::vector<RankedEdge> edges = RankEdges(edited, scores.of_tets);
  Halving halving(std::move(edited), std::move(on_boundary), options);
  halving.Halve(edges, budget);
  Refinement result = halving.Take();
  result.dropped_empty = collapsed.empty;
  result.dropped_flat = collapsed.flat;
  return result;
}

}  // namespace tetrec
