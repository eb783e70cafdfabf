// Slivers, and one huge tet among tiny ones.
#include "stability/mesh_damage.h"

#include "core/error.h"
#include "geometry/orientation.h"
#include "mesh/delaunay.h"
#include "mesh/locate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {
namespace {

constexpr float kSliverShare =
    1e-4f;  // height of a sliver over that of the tet that it was cut from

// The four tets around a vertex inside a tet.
std::array<glm::uvec4, 4> SplitAt(const glm::uvec4& tet, uint32_t inner) {
  std::array<glm::uvec4, 4> parts = {tet, tet, tet, tet};
  for (int i = 0; i < 4; ++i) parts[size_t(i)][i] = inner;
  return parts;
}

bool IsPositive(const TetMesh& mesh, const glm::uvec4& tet) {
  const auto& p = mesh.positions;
  return Orientation(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]) > 0;
}

// Weights of a tet's corners at the new vertex.
constexpr std::array<float, 4> kWeights = {(1 - kSliverShare) / 3, (1 - kSliverShare) / 3,
                                           (1 - kSliverShare) / 3, kSliverShare};

// False, with the mesh as it was, where rounding would turn a part inside out.
bool SplitIntoSliver(TetMesh& mesh, size_t tet_id) {
  const glm::uvec4 tet = mesh.tets[tet_id];
  glm::dvec3 inner(0.0);
  for (int i = 0; i < 4; ++i) {
    inner += double(kWeights[size_t(i)]) * glm::dvec3(mesh.positions[tet[i]]);
  }
  mesh.positions.emplace_back(inner);
  const auto parts = SplitAt(tet, uint32_t(mesh.positions.size() - 1));
  if (!std::ranges::all_of(parts, [&](const glm::uvec4& part) { return IsPositive(mesh, part); })) {
    mesh.positions.pop_back();
    return false;
  }
  mesh.tets[tet_id] = parts[0];
  mesh.tets.insert(mesh.tets.end(), parts.begin() + 1, parts.end());
  return true;
}

}  // namespace

void AddSlivers(RadianceField& field, const Bounds3& bounds, size_t count) {
  TETREC_CHECK(field.storage == FieldStorage::kVertex, "slivers need values at vertices");
  const FieldLayout layout = LayoutOf(field);
  std::vector<float> values = ValuesOf(field);
  const size_t width = values.size() / field.mesh.positions.size();
  TetMesh mesh = std::move(field.mesh);
  std::vector<size_t> candidates;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    if (bounds.Contains(Centroid(mesh, mesh.tets[t]))) candidates.push_back(t);
  }
  size_t made = 0;
  const size_t stride = std::max<size_t>(1, candidates.size() / std::max<size_t>(count, 1));
  for (size_t first = 0; first < stride; ++first) {
    for (size_t i = first; i < candidates.size() && made < count; i += stride) {
      const glm::uvec4 tet = mesh.tets[candidates[i]];
      if (!SplitIntoSliver(mesh, candidates[i])) continue;
      ++made;
      for (size_t c = 0; c < width; ++c) {
        float value = 0;
        for (int k = 0; k < 4; ++k) value += kWeights[size_t(k)] * values[tet[k] * width + c];
        values.push_back(value);
      }
    }
  }
  if (made < count) {
    throw DataError(fmt::format("only {} of {} slivers fit into the {} tets of the subject", made,
                                count, candidates.size()));
  }
  mesh.neighbors = ComputeNeighbors(mesh.tets, mesh.positions.size());
  field = MakeField(std::move(mesh), layout, values);
}

void ReplaceMiddleByOneTet(RadianceField& field, const Bounds3& bounds) {
  TETREC_CHECK(field.storage == FieldStorage::kVertex, "the tet needs values at vertices");
  const glm::dvec3 center = bounds.Center(), size = bounds.Size();
  const double radius = 0.8 * 0.5 * std::min({size.x, size.y, size.z});
  const std::vector<glm::vec3>& before = field.mesh.positions;
  std::vector<glm::vec3> points;
  std::vector<uint32_t> source, dropped;
  for (uint32_t v = 0; v < before.size(); ++v) {
    if (glm::length(glm::dvec3(before[v]) - center) < radius) {
      dropped.push_back(v);
    } else {
      points.push_back(before[v]);
      source.push_back(v);
    }
  }
  if (dropped.empty()) throw DataError("no vertex is in the middle of the subject");
  for (const glm::dvec3 corner :
       {glm::dvec3(1, 1, 1), glm::dvec3(1, -1, -1), glm::dvec3(-1, 1, -1), glm::dvec3(-1, -1, 1)}) {
    const glm::vec3 point(center + 0.99 * radius / std::sqrt(3.0) * corner);
    points.push_back(point);
    source.push_back(*std::ranges::min_element(
        dropped, {}, [&](uint32_t v) { return glm::length(before[v] - point); }));
  }
  DelaunayResult delaunay = BuildDelaunay(points);
  const std::vector<float> values = ValuesOf(field);
  const size_t width = values.size() / before.size();
  std::vector<float> rows;
  for (const uint32_t point : delaunay.point_of_vertex) {
    const auto row = values.begin() + std::ptrdiff_t(source[point] * width);
    rows.insert(rows.end(), row, row + std::ptrdiff_t(width));
  }
  field = MakeField(std::move(delaunay.mesh), LayoutOf(field), rows);
}

}  // namespace tetrec
