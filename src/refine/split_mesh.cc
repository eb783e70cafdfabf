// A mesh that grows: edges are halved, and the tets around them are cut.
#include "refine/split_mesh.h"

#include "geometry/orientation.h"

#include <algorithm>
#include <numeric>

namespace tetrec {

SplitMesh::SplitMesh(TetMesh mesh)
    : mesh_(std::move(mesh)), tets_at_(mesh_.positions.size()), old_tets_(mesh_.tets.size()) {
  mesh_.neighbors = {};
  std::iota(old_tets_.begin(), old_tets_.end(), 0u);
  std::vector<uint32_t> counts(mesh_.positions.size(), 0);
  for (const glm::uvec4& tet : mesh_.tets) {
    for (int i = 0; i < 4; ++i) ++counts[tet[i]];
  }
  for (size_t v = 0; v < counts.size(); ++v) tets_at_[v].reserve(counts[v]);
  for (uint32_t t = 0; t < mesh_.tets.size(); ++t) AddToVertices(t);
}

void SplitMesh::AddToVertices(uint32_t tet) {
  for (int i = 0; i < 4; ++i) tets_at_[mesh_.tets[tet][i]].push_back(tet);
}

glm::vec3 SplitMesh::Middle(uint32_t a, uint32_t b) const {
  return 0.5f * position(a) + 0.5f * position(b);
}

uint32_t SplitMesh::AddMiddle(uint32_t a, uint32_t b) {
  const uint32_t vertex = uint32_t(vertices());
  mesh_.positions.push_back(Middle(a, b));
  tets_at_.emplace_back();
  inserted_.push_back({a, b, 0.5f});
  return vertex;
}

void SplitMesh::Cut(uint32_t tet, std::span<const glm::uvec4> parts) {
  for (int i = 0; i < 4; ++i) std::erase(tets_at_[mesh_.tets[tet][i]], tet);
  mesh_.tets[tet] = parts[0];
  AddToVertices(tet);
  for (const glm::uvec4& part : parts.subspan(1)) {
    mesh_.tets.push_back(part);
    old_tets_.push_back(old_tets_[tet]);
    AddToVertices(uint32_t(mesh_.tets.size() - 1));
  }
}

Refinement SplitMesh::Take() {
  Refinement result{.split_edges = inserted_.size()};
  MeshOrder order = SortAlongMortonCurve(mesh_);
  mesh_.neighbors = ComputeNeighbors(mesh_.tets, mesh_.positions.size());  // faster when sorted
  for (const uint32_t tet : order.tets) result.old_tets.push_back(old_tets_[tet]);
  result.of_vertices = {std::move(inserted_), std::move(order.vertices)};
  result.mesh = std::move(mesh_);
  return result;
}

bool IsPositive(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
  return Orientation(a, b, c, d) > 0;
}

}  // namespace tetrec
