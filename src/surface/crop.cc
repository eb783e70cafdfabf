// Triangles are cut by one face of the box after another.
#include "surface/crop.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

constexpr double kOnFace = 1e-6;  // of the surface's diagonal
constexpr uint32_t kUnused = 0xFFFFFFFFu;

// Vertices of the mesh in the frame of the box, and those that cuts add.
struct CutVertices {
  std::vector<glm::dvec3> positions;
  std::vector<std::array<uint8_t, 3>> colors_srgb;  // empty, or one per vertex
};

// One plane of the box, across an axis.
struct BoxFace {
  int axis;
  double place, inward;  // inward is 1 or -1

  double Depth(const glm::dvec3& p) const { return inward * (p[axis] - place); }
};

class CutByBoxFace {
 public:
  CutByBoxFace(const BoxFace& face, double on_face, CutVertices& vertices)
      : face_(face), vertices_(vertices) {
    for (glm::dvec3& p : vertices_.positions) {
      const double depth = face_.Depth(p);
      const bool is_on_face = std::abs(depth) <= on_face;
      if (is_on_face) p[face_.axis] = face_.place;
      side_.push_back(is_on_face ? 0 : depth > 0 ? 1 : -1);
    }
  }

  // Appends the parts of a triangle on either side. What lies in the face is inside.
  void Cut(const glm::uvec3& t, std::vector<glm::uvec3>& inside, std::vector<glm::uvec3>& outside) {
    std::vector<uint32_t> in, out;  // corners of the parts
    for (int k = 0; k < 3; ++k) {
      const uint32_t a = t[k], b = t[(k + 1) % 3];
      if (side_[a] >= 0) in.push_back(a);
      if (side_[a] <= 0) out.push_back(a);
      if (side_[a] * side_[b] == -1) {
        in.push_back(VertexOnEdge(a, b));
        out.push_back(in.back());
      }
    }
    AddFan(in, inside);
    if (std::min({side_[t.x], side_[t.y], side_[t.z]}) < 0) AddFan(out, outside);
  }

 private:
  static void AddFan(const std::vector<uint32_t>& polygon, std::vector<glm::uvec3>& triangles) {
    for (size_t k = 2; k < polygon.size(); ++k) {
      triangles.emplace_back(polygon[0], polygon[k - 1], polygon[k]);
    }
  }

  // The same vertex for all triangles at an edge.
  uint32_t VertexOnEdge(uint32_t a, uint32_t b) {
    const auto [low, high] = std::minmax(a, b);
    const uint32_t next = uint32_t(vertices_.positions.size());
    const auto [found, is_new] = vertex_on_edge_.try_emplace({low, high}, next);
    if (!is_new) return found->second;
    const glm::dvec3 from = vertices_.positions[low], to = vertices_.positions[high];
    const double share = face_.Depth(from) / (face_.Depth(from) - face_.Depth(to));
    glm::dvec3 cut = glm::mix(from, to, share);
    cut[face_.axis] = face_.place;
    vertices_.positions.push_back(cut);
    if (!vertices_.colors_srgb.empty()) {
      std::array<uint8_t, 3> color = vertices_.colors_srgb[low];
      for (size_t c = 0; c < 3; ++c) {
        color[c] = uint8_t(
            std::lround(glm::mix(double(color[c]), double(vertices_.colors_srgb[high][c]), share)));
      }
      vertices_.colors_srgb.push_back(color);
    }
    return next;
  }

  const BoxFace face_;
  CutVertices& vertices_;
  std::vector<int> side_;  // of each vertex: 1 inside, 0 on the face, -1 outside
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> vertex_on_edge_;
};

TriangleMesh WithUsedVertices(const CutVertices& vertices, const std::vector<glm::uvec3>& triangles,
                              const Similarity3& mesh_from_box) {
  std::vector<uint32_t> new_vertex(vertices.positions.size(), kUnused);
  for (const glm::uvec3& t : triangles) {
    for (int k = 0; k < 3; ++k) new_vertex[t[k]] = 0;
  }
  TriangleMesh mesh;
  for (size_t v = 0; v < new_vertex.size(); ++v) {
    if (new_vertex[v] == kUnused) continue;
    new_vertex[v] = uint32_t(mesh.positions.size());
    mesh.positions.emplace_back(mesh_from_box * vertices.positions[v]);
    if (!vertices.colors_srgb.empty()) mesh.colors_srgb.push_back(vertices.colors_srgb[v]);
  }
  for (const glm::uvec3& t : triangles) {
    mesh.triangles.emplace_back(new_vertex[t.x], new_vertex[t.y], new_vertex[t.z]);
  }
  return mesh;
}

}  // namespace

CutSurface CutByBox(const TriangleMesh& mesh, const Bounds3& box,
                    const Similarity3& box_from_mesh) {
  CutVertices vertices{{}, mesh.colors_srgb};
  Bounds3 bounds;
  for (const glm::vec3& p : mesh.positions) {
    vertices.positions.push_back(box_from_mesh * glm::dvec3(p));
    bounds.Add(vertices.positions.back());
  }
  std::vector<glm::uvec3> inside = mesh.triangles, outside;
  for (int axis = 0; axis < 3; ++axis) {
    for (const BoxFace& face :
         {BoxFace{axis, box.min[axis], 1}, BoxFace{axis, box.max[axis], -1}}) {
      CutByBoxFace cut(face, kOnFace * bounds.Diagonal(), vertices);
      for (const glm::uvec3& triangle : std::exchange(inside, {})) {
        cut.Cut(triangle, inside, outside);
      }
    }
  }
  const Similarity3 mesh_from_box = box_from_mesh.Inverse();
  return {WithUsedVertices(vertices, inside, mesh_from_box),
          WithUsedVertices(vertices, outside, mesh_from_box)};
}

}  // namespace tetrec
