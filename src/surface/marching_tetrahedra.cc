// Level sets of piecewise linear functions on tet meshes.
#include "surface/marching_tetrahedra.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace tetrec {
namespace {

// Even permutations of a tet's vertices, one for each pair of inside vertices, which comes first.
constexpr int kTwoInside[6][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2},
                                  {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}};

class Extraction {
 public:
  Extraction(const TetMesh& mesh, std::span<const float> level, float isovalue)
      : mesh_(mesh), level_(level), isovalue_(isovalue) {}

  void March(uint32_t t) {
    const glm::uvec4& tet = mesh_.tets[t];
    int inside_mask = 0;
    for (int i = 0; i < 4; ++i) inside_mask |= int(IsInside(tet[i])) << i;
    if (inside_mask == 0 || inside_mask == 15) return;
    for (int i = 0; i < 4; ++i) {
      if (inside_mask == 1 << i) CutOff(t, i, true);
      if (inside_mask == (15 ^ 1 << i)) CutOff(t, i, false);
    }
    for (const auto& p : kTwoInside) {
      if (inside_mask != (1 << p[0] | 1 << p[1])) continue;
      Quad(t, Cut(tet[p[0]], tet[p[2]]), Cut(tet[p[0]], tet[p[3]]), Cut(tet[p[1]], tet[p[3]]),
           Cut(tet[p[1]], tet[p[2]]));
    }
  }
  LevelSet Take() { return std::move(set_); }

 private:
  bool IsInside(uint32_t v) const { return level_[v] > isovalue_; }

  // Adds the triangle that separates vertex i from the others. Face i is wound away from vertex i.
  void CutOff(uint32_t t, int i, bool is_inside) {
    const glm::uvec4& tet = mesh_.tets[t];
    uint32_t cut[3];
    for (int k = 0; k < 3; ++k) {
      const uint32_t other = tet[kFaceVertices[i][k]];
      cut[k] = is_inside ? Cut(tet[i], other) : Cut(other, tet[i]);
    }
    Triangle(t, cut[0], cut[is_inside ? 1 : 2], cut[is_inside ? 2 : 1]);
  }

  // Adds a quadrilateral, split along its shorter diagonal.
  void Quad(uint32_t t, uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    const auto& p = set_.positions;
    if (glm::distance(p[a], p[c]) <= glm::distance(p[b], p[d])) {
      Triangle(t, a, b, c);
      Triangle(t, a, c, d);
    } else {
      Triangle(t, a, b, d);
      Triangle(t, b, c, d);
    }
  }

  void Triangle(uint32_t t, uint32_t a, uint32_t b, uint32_t c) {
    set_.triangles.emplace_back(a, b, c);
    set_.tets.push_back(t);
  }

  // The vertex on an edge, created at its first use.
  uint32_t Cut(uint32_t inside, uint32_t outside) {
    const uint64_t key = uint64_t{inside} << 32 | outside;
    const auto [entry, is_new] = vertex_of_edge_.try_emplace(key, uint32_t(set_.cuts.size()));
    if (is_new) {
      const double in = level_[inside], out = level_[outside];
      const double t =
          std::clamp((in - isovalue_) / (in - out), kLeastCutShare, 1 - kLeastCutShare);
      set_.cuts.push_back({inside, outside, float(t)});
      set_.positions.emplace_back(
          glm::mix(glm::dvec3(mesh_.positions[inside]), glm::dvec3(mesh_.positions[outside]), t));
    }
    return entry->second;
  }

  const TetMesh& mesh_;
  std::span<const float> level_;
  float isovalue_;
  std::unordered_map<uint64_t, uint32_t> vertex_of_edge_;
  LevelSet set_;
};

}  // namespace

LevelSet MarchTetrahedra(const TetMesh& mesh, std::span<const float> level, float isovalue) {
  if (level.size() != mesh.positions.size()) {
    throw DataError(fmt::format("{} levels for {} vertices", level.size(), mesh.positions.size()));
  }
  if (!std::isfinite(isovalue)) throw DataError(fmt::format("the isovalue is {}", isovalue));
  for (size_t v = 0; v < level.size(); ++v) {
    if (!std::isfinite(level[v])) {
      throw DataError(fmt::format("the level of vertex {} is {}", v, level[v]));
    }
  }
  Extraction extraction(mesh, level, isovalue);
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) extraction.March(t);
  return extraction.Take();
}

LevelSet KeepTriangles(const LevelSet& set, std::span<const uint8_t> marks) {
  TETREC_CHECK(marks.size() == set.triangles.size(), "one mark per triangle");
  LevelSet kept;
  std::vector<uint32_t> new_vertex(set.positions.size(), kNoTet);
  for (size_t f = 0; f < set.triangles.size(); ++f) {
    if (marks[f] == 0) continue;
    glm::uvec3 triangle = set.triangles[f];
    for (int k = 0; k < 3; ++k) {
      uint32_t& id = new_vertex[triangle[k]];
      if (id == kNoTet) {
        id = uint32_t(kept.cuts.size());
        kept.cuts.push_back(set.cuts[triangle[k]]);
        kept.positions.push_back(set.positions[triangle[k]]);
      }
      triangle[k] = id;
    }
    kept.triangles.push_back(triangle);
    kept.tets.push_back(set.tets[f]);
  }
  return kept;
}

LevelSet CropTo(const LevelSet& set, const Bounds3& bounds) {
  std::vector<uint8_t> is_inside(set.positions.size());
  for (size_t v = 0; v < set.positions.size(); ++v) {
    is_inside[v] = bounds.Contains(glm::dvec3(set.positions[v]));
  }
  std::vector<uint8_t> marks;
  for (const glm::uvec3& t : set.triangles) {
    marks.push_back(is_inside[t.x] & is_inside[t.y] & is_inside[t.z]);
  }
  return KeepTriangles(set, marks);
}

TriangleMesh ColoredSurface(const LevelSet& set, const RadianceField& field) {
  TriangleMesh mesh;
  mesh.positions = set.positions;
  mesh.triangles = set.triangles;
  for (const EdgeCut& cut : set.cuts) {
    const float inside = (1 - cut.t) * std::max(0.0f, field.density[cut.inside]);
    const float outside = cut.t * std::max(0.0f, field.density[cut.outside]);
    const float share = inside + outside > 0 ? outside / (inside + outside) : cut.t;
    const glm::vec3 color =
        glm::mix(field.color_srgb[cut.inside], field.color_srgb[cut.outside], share);
    const glm::vec3 bytes = glm::round(255.0f * glm::clamp(color, 0.0f, 1.0f));
    mesh.colors_srgb.push_back({uint8_t(bytes.r), uint8_t(bytes.g), uint8_t(bytes.b)});
  }
  return mesh;
}

}  // namespace tetrec
