// Places that are clear in a mesh and opaque in the one that replaces it.
#include "refine/darkened.h"

#include "core/parallel.h"
#include "mesh/locate.h"
#include "mesh/mesh_edges.h"
#include "mesh/tet_quality.h"
#include "refine/vertex_values.h"

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

namespace tetrec {
namespace {

// A place is darkened if the opacity over its length rises by this.
constexpr double kDarker = 0.3;

// Values at the vertices of a mesh, linear in its tets.
struct DensityOnMesh {
  const TetMesh& mesh;
  const std::vector<float>& values;

  double At(const glm::uvec4& vertices, const glm::dvec4& weights) const {
    double sum = 0;
    for (int i = 0; i < 4; ++i) sum += weights[i] * double(values[vertices[i]]);
    return sum;
  }
  double At(uint32_t tet, const glm::dvec3& point) const {
    return At(mesh.tets[tet], WeightsInTet(mesh, tet, point));
  }
};

// (V) A tet at each vertex.
std::vector<uint32_t> TetsAtVertices(const TetMesh& mesh) {
  std::vector<uint32_t> tets(mesh.positions.size(), 0);
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) tets[mesh.tets[t][i]] = t;
  }
  return tets;
}

// Gone vertices whose place in the new field is opaque.
std::vector<uint32_t> DarkenedVertices(const DensityOnMesh& old_field,
                                       std::span<const uint32_t> gone,
                                       const DensityOnMesh& new_field) {
  const std::vector<double> lengths = MeanEdgesOfVertices(old_field.mesh);
  std::vector<uint32_t> darkened;
  uint32_t tet = 0;  // near the vertex before, which is often near this one
  for (const uint32_t v : gone) {
    const glm::dvec3 point(old_field.mesh.positions[v]);
    const uint32_t found = FindTet(new_field.mesh, point, tet, true);
    if (found == kNoTet) continue;
    tet = found;
    const double before = Opacity(double(old_field.values[v]), lengths[v]);
    const double after = Opacity(new_field.At(tet, point), lengths[v]);
    if (after - before > kDarker) darkened.push_back(v);
  }
  return darkened;
}

struct RankedPlace {
  double harm;  // the opacity that is new, by the square of the tet's mean edge
  PlaceInTet place;
};
// `rows`: of the new vertices, below the number of old ones if they are old.
std::vector<RankedPlace> DarkenedTets(const DensityOnMesh& old_field,
                                      const DensityOnMesh& new_field,
                                      const std::vector<uint32_t>& rows) {
  const uint32_t old_vertices = uint32_t(old_field.mesh.positions.size());
  const std::vector<uint32_t> tets_at = TetsAtVertices(old_field.mesh);
  std::vector<RankedPlace> darkened;
  std::mutex mutex;
  ParallelFor(new_field.mesh.tets.size(), 1 << 13, [&](size_t begin, size_t end) {
    std::vector<RankedPlace> found;
    uint32_t old_tet = 0;
    for (size_t t = begin; t < end; ++t) {
      const glm::uvec4& tet = new_field.mesh.tets[t];
      const double length = MeanEdge(CornersOf(new_field.mesh.positions, tet));
      const double opacity = Opacity(new_field.At(tet, glm::dvec4(0.25)), length);
      if (opacity <= kDarker) continue;
      const glm::dvec3 point = Centroid(new_field.mesh, tet);
      for (int i = 0; i < 4; ++i) {
        if (rows[tet[i]] < old_vertices) old_tet = tets_at[rows[tet[i]]];
      }
      const uint32_t at = FindTet(old_field.mesh, point, old_tet, true);
      if (at == kNoTet) continue;
      old_tet = at;
      const glm::dvec4 weights = WeightsInTet(old_field.mesh, at, point);
      const double more = opacity - Opacity(old_field.At(old_field.mesh.tets[at], weights), length);
      if (more <= kDarker) continue;
      found.push_back(
          {more * length * length, {glm::vec3(point), old_field.mesh.tets[at], weights}});
    }
    const std::scoped_lock lock(mutex);
    darkened.insert(darkened.end(), found.begin(), found.end());
  });
  return darkened;
}

}  // namespace

DarkenedPlaces FindDarkened(const TetMesh& mesh, const std::vector<float>& density,
                            std::span<const uint32_t> gone, const TetMesh& new_mesh,
                            const Prolongation& of_vertices) {
  const std::vector<float> new_density = Prolong(density, of_vertices);
  const DensityOnMesh old_field{mesh, density}, new_field{new_mesh, new_density};
  DarkenedPlaces darkened{DarkenedVertices(old_field, gone, new_field), {}};
  std::vector<RankedPlace> ranked = DarkenedTets(old_field, new_field, of_vertices.kept);
  // The order in which threads found them does not matter.
  std::ranges::sort(ranked, [](const RankedPlace& a, const RankedPlace& b) {
    const auto key = [](const RankedPlace& r) {
      return std::array{-r.harm, double(r.place.position.x), double(r.place.position.y),
                        double(r.place.position.z)};
    };
    return key(a) < key(b);
  });
  for (const RankedPlace& place : ranked) darkened.places.push_back(place.place);
  return darkened;
}

}  // namespace tetrec
