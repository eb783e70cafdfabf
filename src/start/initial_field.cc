// The field that optimisation starts from.
#include "start/initial_field.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

constexpr glm::vec3 kGrey(0.5f);

// Each vertex' neighbours along edges, ascending.
std::vector<std::vector<uint32_t>> VertexNeighbors(const TetMesh& mesh) {
  std::vector<std::vector<uint32_t>> neighbors(mesh.positions.size());
  for (const glm::uvec4& tet : mesh.tets) {
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) {
        if (i != j) neighbors[tet[i]].push_back(tet[j]);
      }
    }
  }
  for (auto& list : neighbors) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return neighbors;
}

double MeanEdge(const TetMesh& mesh, size_t vertex, const std::vector<uint32_t>& neighbors) {
  double sum = 0;
  for (const uint32_t n : neighbors) {
    sum += glm::distance(glm::dvec3(mesh.positions[vertex]), glm::dvec3(mesh.positions[n]));
  }
  return sum / double(neighbors.size());
}

// Ring by ring: a vertex without a colour takes the mean of its neighbours of the rings before.
std::vector<glm::vec3> SpreadColors(std::span<const std::optional<glm::vec3>> known,
                                    const std::vector<std::vector<uint32_t>>& neighbors) {
  std::vector<glm::vec3> colors(known.size(), kGrey);
  std::vector<uint8_t> has_color(known.size(), 0);
  std::vector<uint32_t> ring;
  for (size_t v = 0; v < known.size(); ++v) {
    if (!known[v]) continue;
    colors[v] = *known[v];
    has_color[v] = 1;
    ring.push_back(uint32_t(v));
  }
  while (!ring.empty()) {
    std::vector<uint32_t> next;
    for (const uint32_t v : ring) {
      for (const uint32_t n : neighbors[v]) {
        if (!has_color[n]) next.push_back(n);
      }
    }
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    for (const uint32_t v : next) {
      glm::vec3 sum(0);
      int count = 0;
      for (const uint32_t n : neighbors[v]) {
        if (!has_color[n]) continue;
        sum += colors[n];
        ++count;
      }
      colors[v] = sum / float(count);
    }
    for (const uint32_t v : next) has_color[v] = 1;
    ring = std::move(next);
  }
  return colors;
}

}  // namespace

RadianceField MakeSubjectField(TetMesh mesh, std::span<const VertexKind> kinds,
                               const InitialFieldOptions& options) {
  TETREC_CHECK(kinds.size() == mesh.positions.size(), "a kind for each vertex");
  RadianceField field;
  for (const VertexKind kind : kinds) {
    const bool is_subject = kind == VertexKind::kSurface || kind == VertexKind::kInner;
    const double share = is_subject ? 1 : kind == VertexKind::kNear ? 0.05 : 0.01;
    field.density.push_back(float(options.density * share));
  }
  field.color_srgb.assign(kinds.size(), kGrey);
  field.mesh = std::move(mesh);
  return field;
}

RadianceField MakePhotoField(TetMesh mesh, std::span<const VertexKind> kinds,
                             std::span<const std::optional<glm::vec3>> colors_srgb,
                             const InitialFieldOptions& options) {
  TETREC_CHECK(kinds.size() == mesh.positions.size(), "a kind for each vertex");
  TETREC_CHECK(colors_srgb.size() == mesh.positions.size(), "a colour or none for each vertex");
  std::vector<double> optical_depths;
  for (size_t v = 0; v < kinds.size(); ++v) {
    const bool is_far = kinds[v] == VertexKind::kFar || kinds[v] == VertexKind::kCorner;
    optical_depths.push_back(is_far           ? options.far_optical_depth
                             : colors_srgb[v] ? options.point_optical_depth
                                              : options.fill_optical_depth);
  }
  return MakeFieldByDepth(std::move(mesh), optical_depths, colors_srgb);
}

RadianceField MakeFieldByDepth(TetMesh mesh, std::span<const double> optical_depths,
                               std::span<const std::optional<glm::vec3>> colors_srgb) {
  TETREC_CHECK(
      optical_depths.size() == mesh.positions.size() && colors_srgb.size() == mesh.positions.size(),
      "an optical depth and a colour or none for each vertex");
  const std::vector<std::vector<uint32_t>> neighbors = VertexNeighbors(mesh);
  RadianceField field;
  for (size_t v = 0; v < optical_depths.size(); ++v) {
    field.density.push_back(float(optical_depths[v] / MeanEdge(mesh, v, neighbors[v])));
  }
  field.color_srgb = SpreadColors(colors_srgb, neighbors);
  field.mesh = std::move(mesh);
  return field;
}

}  // namespace tetrec
