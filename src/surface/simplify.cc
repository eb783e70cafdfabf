// Fewer triangles, by OpenMesh's decimation.
#include "surface/simplify.h"

#include "core/error.h"

#include <fmt/format.h>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#include <OpenMesh/Core/Mesh/TriMesh_ArrayKernelT.hh>
#include <OpenMesh/Tools/Decimater/DecimaterT.hh>
#include <OpenMesh/Tools/Decimater/ModAspectRatioT.hh>
#include <OpenMesh/Tools/Decimater/ModHausdorffT.hh>
#include <OpenMesh/Tools/Decimater/ModNormalFlippingT.hh>
#include <OpenMesh/Tools/Decimater/ModQuadricT.hh>
#pragma GCC diagnostic pop

#include <algorithm>
#include <vector>

namespace tetrec {
namespace {

// A mesh whose edges know whether they may be collapsed.
class HalfEdges : public OpenMesh::TriMesh_ArrayKernelT<> {
 public:
  // Hides the method of the same name, which decimaters ask about every half-edge. Debian builds
  // the library with assertions; those in that method compare names of types and take nine tenths
  // of a decimation. True if nothing here is deleted, the mesh stays a manifold (the link condition
  // of Dey, Edelsbrunner, Guha and Nekhayev, Topology Preserving Edge Contraction, 1999), no two
  // borders meet, and no triangle goes that has two sides at a border.
  bool is_collapse_ok(HalfedgeHandle from_to) {
    const HalfedgeHandle to_from = opposite_halfedge_handle(from_to);
    const VertexHandle from = from_vertex_handle(from_to), to = to_vertex_handle(from_to);
    if (status(edge_handle(from_to)).deleted() || status(from).deleted() || status(to).deleted()) {
      return false;
    }
    if (LosesATriangleWithTwoBorders(from_to) || LosesATriangleWithTwoBorders(to_from))
      return false;
    if (is_boundary(from) && is_boundary(to) && !is_boundary(edge_handle(from_to))) return false;
    const VertexHandle left = Apex(from_to), right = Apex(to_from);
    if (left == right) return false;
    around_from_.clear();
    for (const auto vertex : vv_range(from)) around_from_.push_back(vertex);
    return std::ranges::none_of(vv_range(to), [&](const VertexHandle vertex) {
      return vertex != left && vertex != right &&
             std::ranges::find(around_from_, vertex) != around_from_.end();
    });
  }

 private:
  // The third corner of the triangle at a half-edge, or an invalid handle if there is none.
  VertexHandle Apex(HalfedgeHandle edge) const {
    return is_boundary(edge) ? VertexHandle() : to_vertex_handle(next_halfedge_handle(edge));
  }

  bool LosesATriangleWithTwoBorders(HalfedgeHandle edge) const {
    if (is_boundary(edge)) return false;
    const HalfedgeHandle second = next_halfedge_handle(edge), third = next_halfedge_handle(second);
    return is_boundary(opposite_halfedge_handle(second)) &&
           is_boundary(opposite_halfedge_handle(third));
  }

  std::vector<VertexHandle> around_from_;
};

using Decimater = OpenMesh::Decimater::DecimaterT<HalfEdges>;

// Vertices and faces keep their numbers.
HalfEdges ToHalfEdges(const TriangleMesh& mesh) {
  HalfEdges half_edges;
  std::vector<HalfEdges::VertexHandle> vertices;
  for (const glm::vec3& p : mesh.positions) {
    vertices.push_back(half_edges.add_vertex(HalfEdges::Point(p.x, p.y, p.z)));
  }
  for (size_t f = 0; f < mesh.triangles.size(); ++f) {
    const glm::uvec3& t = mesh.triangles[f];
    if (!half_edges.add_face(vertices[t.x], vertices[t.y], vertices[t.z]).is_valid()) {
      throw DataError(fmt::format("the surface is not a manifold at triangle {} ({}, {}, {})", f,
                                  t.x, t.y, t.z));
    }
  }
  return half_edges;
}

// What is left of `mesh` after edges were collapsed. A half-edge collapse moves no vertex, so the
// remaining ones keep position and colour.
TriangleMesh Remaining(const HalfEdges& half_edges, const TriangleMesh& mesh) {
  TriangleMesh result;
  std::vector<uint32_t> new_vertex(mesh.positions.size());
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const HalfEdges::VertexHandle vertex{int(v)};
    if (half_edges.status(vertex).deleted() || half_edges.is_isolated(vertex)) continue;
    new_vertex[v] = uint32_t(result.positions.size());
    result.positions.push_back(mesh.positions[v]);
    if (!mesh.colors_srgb.empty()) result.colors_srgb.push_back(mesh.colors_srgb[v]);
  }
  for (const auto face : half_edges.faces()) {
    glm::uvec3 triangle;
    int k = 0;
    for (const auto vertex : face.vertices()) triangle[k++] = new_vertex[size_t(vertex.idx())];
    result.triangles.push_back(triangle);
  }
  return result;
}

// Collapses the edge of least quadric error first.
void OrderByQuadrics(Decimater& decimater) {
  OpenMesh::Decimater::ModQuadricT<HalfEdges>::Handle quadric;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();
}

}  // namespace

TriangleMesh Simplify(const TriangleMesh& mesh, double max_deviation) {
  if (!(max_deviation > 0)) return mesh;
  HalfEdges half_edges = ToHalfEdges(mesh);
  Decimater decimater(half_edges);
  OrderByQuadrics(decimater);
  half_edges.request_face_normals();
  half_edges.update_face_normals();
  OpenMesh::Decimater::ModNormalFlippingT<HalfEdges>::Handle turning;
  decimater.add(turning);
  decimater.module(turning).set_max_normal_deviation(60);
  OpenMesh::Decimater::ModAspectRatioT<HalfEdges>::Handle slivers;
  decimater.add(slivers);
  decimater.module(slivers).set_aspect_ratio(4);
  // It takes the longest, so it comes last: it is asked about what the others allow.
  OpenMesh::Decimater::ModHausdorffT<HalfEdges>::Handle distance;
  decimater.add(distance);
  decimater.module(distance).set_tolerance(float(max_deviation));
  decimater.initialize();
  decimater.decimate();
  return Remaining(half_edges, mesh);
}

TriangleMesh Decimate(const TriangleMesh& mesh, uint64_t max_triangles) {
  if (mesh.triangles.size() <= max_triangles) return mesh;
  HalfEdges half_edges = ToHalfEdges(mesh);
  Decimater decimater(half_edges);
  OrderByQuadrics(decimater);
  decimater.initialize();
  decimater.decimate_to_faces(0, max_triangles);
  return Remaining(half_edges, mesh);
}

}  // namespace tetrec
