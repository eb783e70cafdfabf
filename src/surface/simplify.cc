// Fewer triangles, by OpenMesh's decimation.
#include "surface/simplify.h"

#include "core/error.h"
#include "core/parallel.h"
#include "surface/clean.h"

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
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

using HalfEdges = OpenMesh::TriMesh_ArrayKernelT<>;
using Decimater = OpenMesh::Decimater::DecimaterT<HalfEdges>;

// Parts that are simplified in parallel. Their number is fixed, so that the result is the same on
// any number of cores.
constexpr size_t kParts = 4;

// Vertices and faces keep their numbers.
HalfEdges ToHalfEdges(const TriangleMesh& mesh) {
  HalfEdges half_edges;
  // A decimater requests these as well, but releases them when it ends, and with them what it has
  // deleted.
  half_edges.request_vertex_status();
  half_edges.request_edge_status();
  half_edges.request_face_status();
  std::vector<HalfEdges::VertexHandle> vertices;
  for (const glm::vec3& p : mesh.positions) {
    vertices.push_back(half_edges.add_vertex(HalfEdges::Point(p.x, p.y, p.z)));
  }
  for (size_t f = 0; f < mesh.triangles.size(); ++f) {
    const glm::uvec3& t = mesh.triangles[f];
    if (!half_edges.add_face(vertices[t.x], vertices[t.y], vertices[t.z]).is_valid()) {
      const glm::vec3& p = mesh.positions[t.x];
      throw DataError(fmt::format("the surface is not a manifold at ({}, {}, {})", p.x, p.y, p.z));
    }
  }
  return half_edges;
}

std::vector<glm::uvec3> TrianglesOf(const HalfEdges& half_edges) {
  std::vector<glm::uvec3> triangles;
  for (const auto face : half_edges.faces()) {
    glm::uvec3 triangle;
    int k = 0;
    for (const auto vertex : face.vertices()) triangle[k++] = uint32_t(vertex.idx());
    triangles.push_back(triangle);
  }
  return triangles;
}

// What is left of `mesh` after edges were collapsed. A half-edge collapse moves no vertex, so the
// remaining ones keep position and colour.
TriangleMesh Remaining(const TriangleMesh& mesh, std::span<const glm::uvec3> triangles) {
  std::vector<bool> remains(mesh.positions.size(), false);
  for (const glm::uvec3& t : triangles) remains[t.x] = remains[t.y] = remains[t.z] = true;
  TriangleMesh result;
  std::vector<uint32_t> new_vertex(mesh.positions.size());
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (!remains[v]) continue;
    new_vertex[v] = uint32_t(result.positions.size());
    result.positions.push_back(mesh.positions[v]);
    if (!mesh.colors_srgb.empty()) result.colors_srgb.push_back(mesh.colors_srgb[v]);
  }
  for (const glm::uvec3& t : triangles) {
    result.triangles.emplace_back(new_vertex[t.x], new_vertex[t.y], new_vertex[t.z]);
  }
  return result;
}

// Collapses the edge of least quadric error first.
void OrderByQuadrics(Decimater& decimater) {
  OpenMesh::Decimater::ModQuadricT<HalfEdges>::Handle quadric;
  decimater.add(quadric);
  decimater.module(quadric).unset_max_err();
}

// Vertices that are locked stay.
void CollapseWithin(double max_deviation, HalfEdges& half_edges) {
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
}

// The part that each triangle is in: slabs across the longest side, with as many triangles each.
std::vector<uint32_t> CutIntoSlabs(const TriangleMesh& mesh, size_t parts) {
  glm::vec3 low(std::numeric_limits<float>::infinity()), high = -low;
  for (const glm::vec3& p : mesh.positions) low = glm::min(low, p), high = glm::max(high, p);
  const glm::vec3 size = high - low;
  const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  std::vector<std::pair<float, uint32_t>> along_axis;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const glm::uvec3& corners = mesh.triangles[t];
    along_axis.emplace_back(mesh.positions[corners.x][axis] + mesh.positions[corners.y][axis] +
                                mesh.positions[corners.z][axis],
                            t);
  }
  std::sort(along_axis.begin(), along_axis.end());
  std::vector<uint32_t> part_of_triangle(mesh.triangles.size());
  for (size_t i = 0; i < along_axis.size(); ++i) {
    part_of_triangle[along_axis[i].second] = uint32_t(i * parts / along_axis.size());
  }
  return part_of_triangle;
}

// Vertices of several parts, and those next to them. A vertex in between must stay as well: two
// parts could otherwise both connect the same two vertices of the cut.
std::vector<bool> VerticesNearCuts(const TriangleMesh& mesh,
                                   std::span<const uint32_t> part_of_triangle) {
  constexpr uint32_t kNone = 0xFFFFFFFFu;
  std::vector<uint32_t> part(mesh.positions.size(), kNone);
  std::vector<bool> on_cut(part.size(), false);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = mesh.triangles[t][k];
      on_cut[v] = on_cut[v] || (part[v] != kNone && part[v] != part_of_triangle[t]);
      part[v] = part_of_triangle[t];
    }
  }
  std::vector<bool> near_cut = on_cut;
  for (const glm::uvec3& t : mesh.triangles) {
    if (on_cut[t.x] || on_cut[t.y] || on_cut[t.z])
      near_cut[t.x] = near_cut[t.y] = near_cut[t.z] = true;
  }
  return near_cut;
}

// A part of a mesh as a mesh, and which of the whole mesh's vertices each of its vertices is. Where
// fans of the part meet in one vertex only, each has a copy of it.
struct Part {
  TriangleMesh mesh;
  std::vector<uint32_t> whole_vertex;
};

Part Cut(const TriangleMesh& mesh, std::span<const uint32_t> part_of_triangle, uint32_t part) {
  constexpr uint32_t kNone = 0xFFFFFFFFu;
  std::vector<uint32_t> new_vertex(mesh.positions.size(), kNone);
  std::vector<uint32_t> old_vertex;
  TriangleMesh cut;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (part_of_triangle[t] != part) continue;
    glm::uvec3 corners;
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = mesh.triangles[t][k];
      if (new_vertex[v] == kNone) {
        new_vertex[v] = uint32_t(cut.positions.size());
        cut.positions.push_back(mesh.positions[v]);
        old_vertex.push_back(v);
      }
      corners[k] = new_vertex[v];
    }
    cut.triangles.push_back(corners);
  }
  Part result{SeparateFans(cut), {}};
  result.whole_vertex.resize(result.mesh.positions.size());
  for (size_t t = 0; t < cut.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      result.whole_vertex[result.mesh.triangles[t][k]] = old_vertex[cut.triangles[t][k]];
    }
  }
  return result;
}

// The triangles that are left of a part, with the whole mesh's vertices.
std::vector<glm::uvec3> SimplifiedPart(const Part& part, const std::vector<bool>& stays,
                                       double max_deviation) {
  HalfEdges half_edges = ToHalfEdges(part.mesh);
  for (size_t v = 0; v < part.whole_vertex.size(); ++v) {
    half_edges.status(HalfEdges::VertexHandle{int(v)}).set_locked(stays[part.whole_vertex[v]]);
  }
  CollapseWithin(max_deviation, half_edges);
  std::vector<glm::uvec3> triangles = TrianglesOf(half_edges);
  for (glm::uvec3& t : triangles) {
    for (int k = 0; k < 3; ++k) t[k] = part.whole_vertex[t[k]];
  }
  return triangles;
}

}  // namespace

TriangleMesh Simplify(const TriangleMesh& mesh, double max_deviation) {
  if (!(max_deviation > 0)) return mesh;
  HalfEdges half_edges = ToHalfEdges(mesh);
  CollapseWithin(max_deviation, half_edges);
  return Remaining(mesh, TrianglesOf(half_edges));
}

TriangleMesh SimplifyInParts(const TriangleMesh& mesh, double max_deviation) {
  if (!(max_deviation > 0)) return mesh;
  const std::vector<uint32_t> part_of_triangle = CutIntoSlabs(mesh, kParts);
  const std::vector<bool> stays = VerticesNearCuts(mesh, part_of_triangle);
  std::vector<std::vector<glm::uvec3>> by_part(kParts);
  ParallelFor(kParts, 1, [&](size_t begin, size_t end) {
    for (size_t part = begin; part < end; ++part) {
      by_part[part] =
          SimplifiedPart(Cut(mesh, part_of_triangle, uint32_t(part)), stays, max_deviation);
    }
  });
  std::vector<glm::uvec3> triangles;
  for (const auto& part : by_part) triangles.insert(triangles.end(), part.begin(), part.end());
  return Remaining(mesh, triangles);
}

TriangleMesh Decimate(const TriangleMesh& mesh, uint64_t max_triangles) {
  if (mesh.triangles.size() <= max_triangles) return mesh;
  HalfEdges half_edges = ToHalfEdges(mesh);
  Decimater decimater(half_edges);
  OrderByQuadrics(decimater);
  decimater.initialize();
  decimater.decimate_to_faces(0, max_triangles);
  return Remaining(mesh, TrianglesOf(half_edges));
}

}  // namespace tetrec
