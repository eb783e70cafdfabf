// Cleaning of a raw surface: small pieces are dropped, fans that meet in a point are separated.
#include "surface/clean.h"

#include "core/disjoint_sets.h"
#include "geometry/bounds3.h"
#include "mesh/mesh_facts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

namespace tetrec {
namespace {

struct Piece {
  double area = 0;
  double volume = 0;  // signed; meaningful if the piece is closed
  bool closed = true;
  bool contains_camera = false;
  Bounds3 bounds;
};

// The solid angle of a triangle as seen from a point, negative if it shows its back. (Van Oosterom
// and Strackee 1983)
double SolidAngle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
  const double cosine =
      la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb;
  return 2 * std::atan2(glm::dot(a, glm::cross(b, c)), cosine);
}

// Marks the closed pieces that face inward and contain the camera.
void MarkPiecesAround(const glm::dvec3& camera, const TriangleMesh& mesh,
                      const std::vector<uint32_t>& piece_of_vertex,
                      std::map<uint32_t, Piece>& pieces) {
  std::map<uint32_t, double> angles;
  for (const auto& [id, piece] : pieces) {
    if (piece.closed && piece.volume < 0 && piece.bounds.Contains(camera)) angles[id] = 0;
  }
  if (angles.empty()) return;
  for (const glm::uvec3& t : mesh.triangles) {
    const auto found = angles.find(piece_of_vertex[t.x]);
    if (found == angles.end()) continue;
    found->second += SolidAngle(glm::dvec3(mesh.positions[t.x]) - camera,
                                glm::dvec3(mesh.positions[t.y]) - camera,
                                glm::dvec3(mesh.positions[t.z]) - camera);
  }
  for (const auto& [id, angle] : angles) pieces[id].contains_camera |= std::abs(angle) > 2 * M_PI;
}

std::map<uint32_t, Piece> MeasurePieces(const TriangleMesh& mesh,
                                        const std::vector<uint32_t>& piece_of_vertex) {
  std::map<uint32_t, Piece> pieces;
  std::vector<std::pair<uint64_t, uint32_t>> edges;  // undirected edge, piece
  for (const glm::uvec3& t : mesh.triangles) {
    const uint32_t id = piece_of_vertex[t.x];
    // Relative to a vertex of the piece, so that volumes of distant pieces keep their precision.
    const glm::dvec3 origin(mesh.positions[id]);
    const glm::dvec3 a = glm::dvec3(mesh.positions[t.x]) - origin,
                     b = glm::dvec3(mesh.positions[t.y]) - origin,
                     c = glm::dvec3(mesh.positions[t.z]) - origin;
    pieces[id].area += 0.5 * glm::length(glm::cross(b - a, c - a));
    pieces[id].volume += glm::dot(a, glm::cross(b, c)) / 6;
    for (int k = 0; k < 3; ++k) {
      const uint32_t from = t[k], to = t[(k + 1) % 3];
      pieces[id].bounds.Add(glm::dvec3(mesh.positions[from]));
      edges.emplace_back(uint64_t{std::min(from, to)} << 32 | std::max(from, to), id);
    }
  }
  std::sort(edges.begin(), edges.end());
  for (size_t e = 0; e < edges.size();) {
    size_t end = e;
    while (end < edges.size() && edges[end].first == edges[e].first) ++end;
    if (end - e != 2) pieces[edges[e].second].closed = false;
    e = end;
  }
  return pieces;
}

std::map<uint32_t, Piece> FindPieces(const TriangleMesh& mesh,
                                     const std::vector<uint32_t>& piece_of_vertex,
                                     const std::vector<glm::dvec3>& cameras) {
  std::map<uint32_t, Piece> pieces = MeasurePieces(mesh, piece_of_vertex);
  for (const glm::dvec3& camera : cameras) {
    MarkPiecesAround(camera, mesh, piece_of_vertex, pieces);
  }
  return pieces;
}

// The marked vertices and the triangles between them, in their order.
TriangleMesh KeepVertices(const TriangleMesh& mesh, const std::vector<uint8_t>& marks) {
  TriangleMesh kept;
  std::vector<uint32_t> new_vertex(mesh.positions.size());
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (marks[v] == 0) continue;
    new_vertex[v] = uint32_t(kept.positions.size());
    kept.positions.push_back(mesh.positions[v]);
    if (!mesh.colors_srgb.empty()) kept.colors_srgb.push_back(mesh.colors_srgb[v]);
  }
  for (const glm::uvec3& t : mesh.triangles) {
    if ((marks[t.x] & marks[t.y] & marks[t.z]) == 0) continue;
    kept.triangles.emplace_back(new_vertex[t.x], new_vertex[t.y], new_vertex[t.z]);
  }
  return kept;
}

}  // namespace

CleanResult KeepLargePieces(const TriangleMesh& mesh, const CleanOptions& options,
                            const TriangleMesh* main_part) {
  const std::vector<uint32_t> piece_of_vertex = PieceOfVertex(mesh);
  const std::map<uint32_t, Piece> pieces = FindPieces(mesh, piece_of_vertex, options.cameras);
  CleanResult result;
  result.components = pieces.size();
  const auto is_cavity = [&](const Piece& p) {
    return !options.keep_cavities && p.closed && p.volume < 0 && !p.contains_camera;
  };
  const auto largest_of = [&](const std::map<uint32_t, Piece>& measured) {
    double largest = 0;
    for (const auto& [id, piece] : measured) {
      if (!is_cavity(piece)) largest = std::max(largest, piece.area);
    }
    return largest;
  };
  const double largest =
      main_part == nullptr
          ? largest_of(pieces)
          : largest_of(FindPieces(*main_part, PieceOfVertex(*main_part), options.cameras));
  std::vector<uint8_t> is_kept(mesh.positions.size(), 0);
  for (const auto& [id, piece] : pieces) {
    if (is_cavity(piece)) {
      ++result.dropped_cavities;
    } else if (piece.area < options.min_component_share * largest) {
      ++result.dropped_small;
    } else {
      is_kept[id] = 1;
    }
  }

  std::vector<uint8_t> of_vertices(mesh.positions.size());
  for (size_t v = 0; v < of_vertices.size(); ++v) of_vertices[v] = is_kept[piece_of_vertex[v]];
  result.mesh = KeepVertices(mesh, of_vertices);
  result.dropped_triangles = mesh.triangles.size() - result.mesh.triangles.size();
  return result;
}

TriangleMesh SeparateFans(const TriangleMesh& mesh) {
  // Corners (triangle * 3 + k) of one vertex belong to the same fan if they share an edge.
  struct Side {
    uint64_t edge;
    uint32_t low_corner, high_corner;  // corners at the edge's smaller and larger vertex
  };
  std::vector<Side> sides;
  for (size_t f = 0; f < mesh.triangles.size(); ++f) {
    for (uint32_t k = 0; k < 3; ++k) {
      const uint32_t next = (k + 1) % 3, a = mesh.triangles[f][int(k)],
                     b = mesh.triangles[f][int(next)];
      const uint32_t corner_a = uint32_t(3 * f) + k, corner_b = uint32_t(3 * f) + next;
      sides.push_back({uint64_t{std::min(a, b)} << 32 | std::max(a, b), a < b ? corner_a : corner_b,
                       a < b ? corner_b : corner_a});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.edge != b.edge ? a.edge < b.edge : a.low_corner < b.low_corner;
  });
  DisjointSets fans(3 * mesh.triangles.size());
  for (size_t s = 1; s < sides.size(); ++s) {
    if (sides[s].edge != sides[s - 1].edge) continue;
    fans.Join(sides[s].low_corner, sides[s - 1].low_corner);
    fans.Join(sides[s].high_corner, sides[s - 1].high_corner);
  }

  TriangleMesh result = mesh;
  constexpr uint32_t kNone = 0xFFFFFFFFu;
  std::vector<uint32_t> first_fan(mesh.positions.size(), kNone);
  std::vector<uint32_t> vertex_of_fan(3 * mesh.triangles.size(), kNone);
  for (uint32_t corner = 0; corner < vertex_of_fan.size(); ++corner) {
    const uint32_t fan = fans.Root(corner), vertex = mesh.triangles[corner / 3][int(corner % 3)];
    if (first_fan[vertex] == kNone) first_fan[vertex] = fan;
    if (vertex_of_fan[fan] == kNone) {
      const bool is_first = first_fan[vertex] == fan;
      vertex_of_fan[fan] = is_first ? vertex : uint32_t(result.positions.size());
      if (!is_first) {
        result.positions.push_back(mesh.positions[vertex]);
        if (!mesh.colors_srgb.empty()) result.colors_srgb.push_back(mesh.colors_srgb[vertex]);
      }
    }
    result.triangles[corner / 3][int(corner % 3)] = vertex_of_fan[fan];
  }
  return result;
}

}  // namespace tetrec
