// A mesh that is changed in place: edges are halved or collapsed, and the tets around them follow.
#include "refine/edited_mesh.h"

#include "geometry/orientation.h"

#include <array>
#include <numeric>

namespace tetrec {

EditedMesh::EditedMesh(TetMesh mesh)
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

void EditedMesh::AddToVertices(uint32_t tet) {
  for (int i = 0; i < 4; ++i) tets_at_[mesh_.tets[tet][i]].push_back(tet);
}

glm::vec3 EditedMesh::Middle(uint32_t a, uint32_t b) const {
  return 0.5f * position(a) + 0.5f * position(b);
}

uint32_t EditedMesh::AddMiddle(uint32_t a, uint32_t b) {
  const uint32_t vertex = uint32_t(vertices());
  mesh_.positions.push_back(Middle(a, b));
  tets_at_.emplace_back();
  inserted_.push_back({a, b, 0.5f});
  return vertex;
}

void EditedMesh::Cut(uint32_t tet, std::span<const glm::uvec4> parts) {
  for (int i = 0; i < 4; ++i) std::erase(tets_at_[mesh_.tets[tet][i]], tet);
  mesh_.tets[tet] = parts[0];
  AddToVertices(tet);
  for (const glm::uvec4& part : parts.subspan(1)) {
    mesh_.tets.push_back(part);
    old_tets_.push_back(old_tets_[tet]);
    AddToVertices(uint32_t(mesh_.tets.size() - 1));
  }
}

std::vector<uint32_t> EditedMesh::TetsAround(uint32_t a, uint32_t b) const {
  std::vector<uint32_t> tets;
  for (const uint32_t t : tets_at_[a]) {
    if (Contains(mesh_.tets[t], b)) tets.push_back(t);
  }
  return tets;
}

bool EditedMesh::Halve(uint32_t a, uint32_t b, std::span<const uint32_t> around) {
  const uint32_t middle = uint32_t(vertices());
  const glm::vec3 place = Middle(a, b);
  const auto at = [&](uint32_t v) { return v == middle ? place : position(v); };
  std::vector<std::array<glm::uvec4, 2>> halves;
  for (const uint32_t t : around) {
    halves.push_back({WithVertexReplaced(mesh_.tets[t], b, middle),
                      WithVertexReplaced(mesh_.tets[t], a, middle)});
    for (const glm::uvec4& half : halves.back()) {
      if (!IsPositive(at(half[0]), at(half[1]), at(half[2]), at(half[3]))) return false;
    }
  }
  AddMiddle(a, b);
  for (size_t i = 0; i < around.size(); ++i) Cut(around[i], halves[i]);
  return true;
}

void EditedMesh::Collapse(uint32_t gone, uint32_t onto) {
  for (const uint32_t t : tets_at_[gone]) {
    glm::uvec4& tet = mesh_.tets[t];
    const bool vanishes = Contains(tet, onto);
    for (int i = 0; i < 4; ++i) {
      if (vanishes && tet[i] != gone) std::erase(tets_at_[tet[i]], t);
      if (!vanishes && tet[i] == gone) tet[i] = onto;
    }
    if (vanishes) {
      tet = glm::uvec4(kNoTet);
    } else {
      tets_at_[onto].push_back(t);
    }
  }
  tets_at_[gone] = {};
  ++gone_vertices_;
}

// Drops what is gone; returns the ids of what is left.
MeshOrder EditedMesh::Compact() {
  MeshOrder left;
  std::vector<uint32_t> new_ids(vertices(), kNoTet);
  for (uint32_t v = 0; v < vertices(); ++v) {
    if (tets_at_[v].empty()) continue;
    new_ids[v] = uint32_t(left.vertices.size());
    mesh_.positions[left.vertices.size()] = mesh_.positions[v];
    left.vertices.push_back(v);
  }
  for (uint32_t t = 0; t < tets(); ++t) {
    if (!HasTet(t)) continue;
    glm::uvec4 tet = mesh_.tets[t];
    for (int i = 0; i < 4; ++i) tet[i] = new_ids[tet[i]];
    mesh_.tets[left.tets.size()] = tet;
    left.tets.push_back(t);
  }
  tets_at_ = {};
  mesh_.positions.resize(left.vertices.size());
  mesh_.tets.resize(left.tets.size());
  return left;
}

Refinement EditedMesh::Take() {
  Refinement result{.split_edges = inserted_.size()};
  const MeshOrder left = Compact();
  const MeshOrder order = SortAlongMortonCurve(mesh_);
  mesh_.neighbors = ComputeNeighbors(mesh_.tets, mesh_.positions.size());  // faster when sorted
  for (const uint32_t tet : order.tets) result.old_tets.push_back(old_tets_[left.tets[tet]]);
  result.of_vertices.inserted = std::move(inserted_);
  for (const uint32_t v : order.vertices) result.of_vertices.kept.push_back(left.vertices[v]);
  result.mesh = std::move(mesh_);
  return result;
}

bool Contains(const glm::uvec4& tet, uint32_t vertex) {
  return glm::any(glm::equal(tet, glm::uvec4(vertex)));
}

glm::uvec4 WithVertexReplaced(glm::uvec4 tet, uint32_t gone, uint32_t onto) {
  for (int i = 0; i < 4; ++i) {
    if (tet[i] == gone) tet[i] = onto;
  }
  return tet;
}

bool IsPositive(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c, const glm::vec3& d) {
  return Orientation(a, b, c, d) > 0;
}

}  // namespace tetrec
