// Delaunay tetrahedralization with CGAL.
#include "mesh/delaunay.h"

#include "core/error.h"
#include "core/process_memory.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetrec {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<uint32_t, Kernel>;
using Triangulation =
    CGAL::Delaunay_triangulation_3<Kernel, CGAL::Triangulation_data_structure_3<VertexBase>>;

// Rejects NaN and infinity, which a release build of CGAL accepts silently.
std::vector<Kernel::Point_3> CheckedPoints(std::span<const glm::vec3> points) {
  if (points.size() < 4) {
    throw DataError(fmt::format("{} points are too few for a tetrahedron: at least 4 are needed",
                                points.size()));
  }
  if (points.size() >= kNoTet) {
    throw DataError(fmt::format("{} points are too many for 32-bit ids", points.size()));
  }
  std::vector<Kernel::Point_3> checked;
  checked.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const glm::vec3& p = points[i];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      throw DataError(fmt::format("point {} of {} is not finite: ({}, {}, {})", i, points.size(),
                                  p.x, p.y, p.z));
    }
    checked.emplace_back(p.x, p.y, p.z);
  }
  return checked;
}

// Inserts in spatial order, so that each point is near the previous one. The info of a vertex is
// the smallest input index of its point.
Triangulation Insert(const std::vector<Kernel::Point_3>& points) {
  std::vector<size_t> order(points.size());  // size_t: the key type of CGAL's property map
  std::iota(order.begin(), order.end(), size_t{0});
  using Map = CGAL::Pointer_property_map<Kernel::Point_3>::const_type;
  CGAL::spatial_sort(
      order.begin(), order.end(),
      CGAL::Spatial_sort_traits_adapter_3<Kernel, Map>(CGAL::make_property_map(points.data())));
  Triangulation triangulation;
  Triangulation::Cell_handle hint;
  size_t count = 0;
  for (const size_t i : order) {
    const auto vertex = triangulation.insert(points[i], hint);
    const bool is_new = triangulation.number_of_vertices() > count;
    count = triangulation.number_of_vertices();
    vertex->info() = is_new ? uint32_t(i) : std::min(vertex->info(), uint32_t(i));
    hint = vertex->cell();
  }
  return triangulation;
}

// Without neighbours.
DelaunayResult Extract(Triangulation& triangulation, std::span<const glm::vec3> points) {
  DelaunayResult result;
  TetMesh& mesh = result.mesh;
  mesh.positions.reserve(triangulation.number_of_vertices());
  result.point_of_vertex.reserve(triangulation.number_of_vertices());
  for (const auto vertex : triangulation.finite_vertex_handles()) {
    result.point_of_vertex.push_back(vertex->info());
    mesh.positions.push_back(points[vertex->info()]);
    vertex->info() = uint32_t(mesh.positions.size() - 1);
  }
  mesh.tets.reserve(triangulation.number_of_finite_cells());
  for (const auto cell : triangulation.finite_cell_handles()) {
    glm::uvec4 tet;
    for (int i = 0; i < 4; ++i) tet[i] = cell->vertex(i)->info();
    mesh.tets.push_back(tet);
  }
  return result;
}

// Frees the triangulation, which takes more memory than anything else here, before the mesh is
// sorted and its tets find their neighbours.
DelaunayResult Triangulate(std::span<const glm::vec3> points) {
  Triangulation triangulation = Insert(CheckedPoints(points));
  if (triangulation.dimension() < 3) {
    throw DataError(fmt::format(
        "{} points have no volume ({} distinct, all in one plane, line or point): they cannot be "
        "tetrahedralized",
        points.size(), triangulation.number_of_vertices()));
  }
  return Extract(triangulation, points);
}

}  // namespace

DelaunayResult BuildDelaunay(std::span<const glm::vec3> points) {
  DelaunayResult result = Triangulate(points);
  ReturnFreedMemory();
  const std::vector<uint32_t> old_of_new = SortAlongMortonCurve(result.mesh).vertices;
  result.mesh.neighbors = ComputeNeighbors(result.mesh.tets, result.mesh.positions.size());
  std::vector<uint32_t> point_of_vertex(old_of_new.size());
  for (size_t v = 0; v < old_of_new.size(); ++v) {
    point_of_vertex[v] = result.point_of_vertex[old_of_new[v]];
  }
  result.point_of_vertex = std::move(point_of_vertex);
  return result;
}

}  // namespace tetrec
