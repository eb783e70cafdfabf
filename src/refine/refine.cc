// Coarse to fine: schemes that refine a mesh, behind one interface.
#include "refine/refine.h"

#include "core/error.h"
#include "mesh/boundary.h"
#include "refine/bisect.h"
#include "refine/halve_edges.h"
#include "refine/insert_vertices.h"
#include "refine/split_prisms.h"

#include <algorithm>
#include <numeric>

namespace tetrec {
namespace {

Refinement RefineMesh(TetMesh mesh, const FieldState& state, const RefineScores& scores,
                      const RefineOptions& options) {
  switch (options.scheme) {
    case RefineScheme::kInsert:
      return InsertVertices(std::move(mesh), state, scores, options);
    case RefineScheme::kHalve:
      return HalveEdges(std::move(mesh), state, scores, options);
    case RefineScheme::kPrism:
      return SplitPrisms(std::move(mesh), scores, options);
    case RefineScheme::kBisect:
      return BisectTets(std::move(mesh), scores, options);
  }
  TETREC_CHECK(false, "no such scheme of refinement");
  return {};
}

}  // namespace

void CompleteScores(const TetMesh& mesh, RefineScores& scores) {
  const size_t vertices = mesh.positions.size();
  if (scores.of_vertices.empty()) {
    TETREC_CHECK(scores.of_tets.size() == mesh.tets.size(), "one score per tet");
    scores.of_vertices.assign(vertices, 0.0f);
    for (size_t t = 0; t < mesh.tets.size(); ++t) {
      for (int i = 0; i < 4; ++i) scores.of_vertices[mesh.tets[t][i]] += 0.25f * scores.of_tets[t];
    }
  } else if (scores.of_tets.empty()) {
    TETREC_CHECK(scores.of_vertices.size() == vertices, "one score per vertex");
    std::vector<float> tets_at(vertices, 0.0f);
    for (const glm::uvec4& tet : mesh.tets) {
      for (int i = 0; i < 4; ++i) ++tets_at[tet[i]];
    }
    for (const glm::uvec4& tet : mesh.tets) {
      float sum = 0.0f;
      for (int i = 0; i < 4; ++i) sum += scores.of_vertices[tet[i]] / tets_at[tet[i]];
      scores.of_tets.push_back(sum);
    }
  }
}

std::vector<uint8_t> FixedVertices(const TetMesh& mesh, const RefineScores& scores) {
  std::vector<uint8_t> stays = BoundaryVertices(mesh);
  for (size_t v = 0; v < scores.is_kept.size(); ++v) stays[v] |= scores.is_kept[v];
  return stays;
}

uint64_t VertexBudget(size_t vertices, const RefineOptions& options) {
  return uint64_t(std::min(double(options.max_vertices), options.growth * double(vertices)));
}

std::vector<uint32_t> WorstFirst(const std::vector<float>& scores) {
  std::vector<uint32_t> order(scores.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return scores[a] > scores[b]; });
  return order;
}

RefineResult Refine(TetMesh mesh, const FieldState& state, RefineScores scores,
                    const RefineOptions& options) {
  CompleteScores(mesh, scores);
  RefineResult result{RefineMesh(std::move(mesh), state, scores, options), {}};
  const bool has_cells = state.layout.storage == FieldStorage::kCell;
  result.state = has_cells ? Prolong(state, Prolongation{{}, result.old_tets})
                           : Prolong(state, result.of_vertices);
  return result;
}

}  // namespace tetrec
