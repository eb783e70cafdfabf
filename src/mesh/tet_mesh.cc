// Tetrahedral meshes: neighbour links, checks, quality and order.
#include "mesh/tet_mesh.h"

#include "core/error.h"
#include "core/parallel.h"
#include "geometry/orientation.h"
#include "mesh/boundary.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace tetrec {
namespace {

void CheckSizesAndIds(const TetMesh& mesh) {
  if (mesh.tets.empty()) throw DataError("the mesh has no tet");
  if (mesh.tets.size() >= kNoTet || mesh.positions.size() >= kNoTet) {
    throw DataError(fmt::format("{} tets and {} vertices are too many for 32-bit ids",
                                mesh.tets.size(), mesh.positions.size()));
  }
  if (mesh.neighbors.size() != mesh.tets.size()) {
    throw DataError(fmt::format("the mesh has {} tets but neighbours for {}", mesh.tets.size(),
                                mesh.neighbors.size()));
  }
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const glm::vec3& p = mesh.positions[v];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      throw DataError(fmt::format("vertex {} is not finite: ({}, {}, {})", v, p.x, p.y, p.z));
    }
  }
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      if (mesh.tets[t][i] >= mesh.positions.size()) {
        throw DataError(
            fmt::format("tet {} names vertex {} of {}", t, mesh.tets[t][i], mesh.positions.size()));
      }
      const uint32_t neighbor = mesh.neighbors[t][i];
      if (neighbor != kNoTet && neighbor >= mesh.tets.size()) {
        throw DataError(
            fmt::format("tet {} names neighbour {} of {}", t, neighbor, mesh.tets.size()));
      }
    }
  }
}

int OrientationOf(const TetMesh& mesh, const glm::uvec4& tet) {
  return Orientation(mesh.positions[tet[0]], mesh.positions[tet[1]], mesh.positions[tet[2]],
                     mesh.positions[tet[3]]);
}

void CheckOrientations(const TetMesh& mesh) {
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    const glm::uvec4 tet = mesh.tets[t];
    const int sign = OrientationOf(mesh, tet);
    if (sign > 0) continue;
    throw DataError(fmt::format("tet {} (vertices {}, {}, {}, {}) is {}: its volume is {:.6g}", t,
                                tet[0], tet[1], tet[2], tet[3], sign < 0 ? "inverted" : "flat",
                                sign < 0 ? TetVolume(mesh, tet) : 0.0));
  }
}

glm::uvec3 SortedFace(const glm::uvec4& tet, int face) {
  glm::uvec3 v;
  for (int i = 0, k = 0; i < 4; ++i) {
    if (i != face) v[k++] = tet[i];
  }
  if (v.x > v.y) std::swap(v.x, v.y);
  if (v.y > v.z) std::swap(v.y, v.z);
  if (v.x > v.y) std::swap(v.x, v.y);
  return v;
}

// For every link there must be one back, over the same three vertices.
void CheckLinks(const TetMesh& mesh) {
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      const uint32_t neighbor = mesh.neighbors[t][i];
      if (neighbor == kNoTet) continue;
      if (neighbor == t) throw DataError(fmt::format("tet {} links to itself over face {}", t, i));
      int back = 0;
      while (back < 4 && mesh.neighbors[neighbor][back] != t) ++back;
      if (back == 4) {
        throw DataError(fmt::format(
            "tet {} links to {} over its face {}, but that has no link back", t, neighbor, i));
      }
      const glm::uvec3 face = SortedFace(mesh.tets[t], i);
      // In a damaged mesh a tet may link back twice; the right link is the one over the same face.
      bool is_shared = false;
      for (int k = back; k < 4; ++k) {
        is_shared |= mesh.neighbors[neighbor][k] == t && SortedFace(mesh.tets[neighbor], k) == face;
      }
      if (!is_shared) {
        throw DataError(
            fmt::format("tet {} links to {} over its face {} ({}-{}-{}), which that lacks", t,
                        neighbor, i, face.x, face.y, face.z));
      }
    }
  }
}

// The links must be the ones that the vertex ids imply.
void CheckNoLinkMissing(const TetMesh& mesh) {
  const std::vector<glm::uvec4> expected = ComputeNeighbors(mesh.tets, mesh.positions.size());
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    if (mesh.neighbors[t] == expected[t]) continue;
    for (int i = 0; i < 4; ++i) {
      if (mesh.neighbors[t][i] == expected[t][i]) continue;
      throw DataError(fmt::format("face {} of tet {} links to {} but is shared with {} ({} = none)",
                                  i, t, mesh.neighbors[t][i], expected[t][i], kNoTet));
    }
  }
}

void CheckAllReferenced(const TetMesh& mesh) {
  std::vector<uint8_t> used(mesh.positions.size(), 0);
  for (const glm::uvec4& tet : mesh.tets) {
    for (int i = 0; i < 4; ++i) used[tet[i]] = 1;
  }
  for (size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) throw DataError(fmt::format("vertex {} belongs to no tet", v));
  }
}

// Spreads the low 21 bits to every third bit.
uint64_t SpreadBits(uint64_t x) {
  x &= 0x1FFFFF;
  x = (x | x << 32) & 0x1F00000000FFFF;
  x = (x | x << 16) & 0x1F0000FF0000FF;
  x = (x | x << 8) & 0x100F00F00F00F00F;
  x = (x | x << 4) & 0x10C30C30C30C30C3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

constexpr size_t kVerticesPerTask = 4096, kTetsPerTask = 16384;

struct MortonKey {
  uint64_t code;
  uint32_t index;
};

// Sorts by code, in time linear in the keys; equal codes keep their order.
void SortByCode(std::vector<MortonKey>& keys) {
  constexpr int kDigitBits = 11, kDigits = 6;
  constexpr size_t kBuckets = size_t{1} << kDigitBits;
  const auto digit = [](const MortonKey& key, int i) {
    return size_t(key.code >> (i * kDigitBits)) % kBuckets;
  };
  std::vector<std::array<uint32_t, kBuckets>> counts(kDigits);
  for (const MortonKey& key : keys) {
    for (int i = 0; i < kDigits; ++i) ++counts[size_t(i)][digit(key, i)];
  }
  std::vector<MortonKey> sorted(keys.size());
  for (int i = 0; i < kDigits; ++i) {
    std::array<uint32_t, kBuckets>& place = counts[size_t(i)];
    std::exclusive_scan(place.begin(), place.end(), place.begin(), 0u);
    for (const MortonKey& key : keys) sorted[place[digit(key, i)]++] = key;
    keys.swap(sorted);
  }
}

// Indices of `count` points, given by point(index), along a Morton curve through their bounding
// cube. Points of equal code keep their order.
template <class PointOf>
std::vector<uint32_t> MortonOrder(size_t count, const PointOf& point) {
  glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
  for (size_t i = 0; i < count; ++i) {
    const glm::dvec3 p(point(i));
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::dvec3 size = high - low;
  const double longest = std::max({size.x, size.y, size.z});
  const double scale = longest > 0 ? double((1 << 21) - 1) / longest : 0.0;
  std::vector<MortonKey> keys(count);
  for (size_t i = 0; i < count; ++i) {
    const glm::dvec3 cell = (glm::dvec3(point(i)) - low) * scale;
    keys[i] = {SpreadBits(uint64_t(cell.x)) | SpreadBits(uint64_t(cell.y)) << 1 |
                   SpreadBits(uint64_t(cell.z)) << 2,
               uint32_t(i)};
  }
  SortByCode(keys);
  std::vector<uint32_t> order(count);
  for (size_t i = 0; i < count; ++i) order[i] = keys[i].index;
  return order;
}

std::vector<uint32_t> Inverse(const std::vector<uint32_t>& order) {
  std::vector<uint32_t> inverse(order.size());
  for (size_t i = 0; i < order.size(); ++i) inverse[order[i]] = uint32_t(i);
  return inverse;
}

// (V + 1) Where the faces of each vertex begin. A face belongs to its smallest vertex; such groups
// are short, so matching within them is cheap.
std::vector<uint32_t> FirstFaces(std::span<const glm::uvec4> tets, size_t vertex_count) {
  std::vector<uint32_t> begin(vertex_count + 1, 0);
  for (size_t t = 0; t < tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      const glm::uvec3 face = SortedFace(tets[t], i);
      if (face.z >= vertex_count) {
        throw DataError(fmt::format("tet {} names vertex {} of {}", t, face.z, vertex_count));
      }
      if (face.x == face.y || face.y == face.z) {
        throw DataError(fmt::format("tet {} names vertex {} twice", t, face.y));
      }
      ++begin[face.x + 1];
    }
  }
  std::partial_sum(begin.begin(), begin.end(), begin.begin());
  return begin;
}

struct FaceEntry {
  uint32_t middle, largest, tet_face;  // tet * 4 + face
  bool operator<(const FaceEntry& b) const {
    return std::tie(middle, largest, tet_face) < std::tie(b.middle, b.largest, b.tet_face);
  }
  bool SameFace(const FaceEntry& b) const { return middle == b.middle && largest == b.largest; }
};

// Links the tets that share a face of a vertex. `faces`: of the vertex.
void LinkSharedFaces(std::span<FaceEntry> faces, size_t vertex,
                     std::vector<glm::uvec4>& neighbors) {
  std::sort(faces.begin(), faces.end());
  for (size_t e = 0; e + 1 < faces.size(); ++e) {
    const FaceEntry &a = faces[e], &b = faces[e + 1];
    if (!a.SameFace(b)) continue;
    if (e + 2 < faces.size() && b.SameFace(faces[e + 2])) {
      throw DataError(fmt::format("face {}-{}-{} is shared by tets {}, {} and {}", vertex, a.middle,
                                  a.largest, a.tet_face / 4, b.tet_face / 4,
                                  faces[e + 2].tet_face / 4));
    }
    neighbors[a.tet_face / 4][a.tet_face % 4] = b.tet_face / 4;
    neighbors[b.tet_face / 4][b.tet_face % 4] = a.tet_face / 4;
    ++e;
  }
}

// Links the tets across the faces that belong to the vertices from `first_vertex` on. `begin`:
// where the faces of these vertices begin, and where the last ones end.
void MatchFaces(std::span<const glm::uvec4> tets, std::span<const uint32_t> begin,
                uint32_t first_vertex, std::vector<glm::uvec4>& neighbors) {
  const size_t vertices = begin.size() - 1;
  std::vector<FaceEntry> entries(begin[vertices] - begin[0]);
  std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
  for (size_t t = 0; t < tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      const glm::uvec3 face = SortedFace(tets[t], i);
      if (face.x - first_vertex >= vertices) continue;  // those before it wrap around
      const uint32_t place = next[face.x - first_vertex]++ - begin[0];
      entries[place] = {face.y, face.z, uint32_t(t * 4 + i)};
    }
  }
  ParallelFor(vertices, kVerticesPerTask, [&](size_t first, size_t last) {
    for (size_t v = first; v < last; ++v) {
      LinkSharedFaces(std::span(entries).subspan(begin[v] - begin[0], begin[v + 1] - begin[v]),
                      first_vertex + v, neighbors);
    }
  });
}

}  // namespace

double TetVolume(const TetMesh& mesh, const glm::uvec4& tet) {
  const glm::dvec3 p0(mesh.positions[tet[0]]), p1(mesh.positions[tet[1]]),
      p2(mesh.positions[tet[2]]), p3(mesh.positions[tet[3]]);
  return glm::dot(p1 - p0, glm::cross(p2 - p0, p3 - p0)) / 6;
}

double RadiusRatio(const TetMesh& mesh, const glm::uvec4& tet) {
  const glm::dvec3 origin(mesh.positions[tet[0]]);
  const glm::dvec3 a = glm::dvec3(mesh.positions[tet[1]]) - origin;
  const glm::dvec3 b = glm::dvec3(mesh.positions[tet[2]]) - origin;
  const glm::dvec3 c = glm::dvec3(mesh.positions[tet[3]]) - origin;
  const glm::dvec3 bc = glm::cross(b, c), ca = glm::cross(c, a), ab = glm::cross(a, b);
  const double volume = glm::dot(a, bc) / 6;
  // r_in = 3 V / (sum of areas), r_circ = |a^2 bc + b^2 ca + c^2 ab| / (12 V).
  const double area =
      0.5 * (glm::length(bc) + glm::length(ca) + glm::length(ab) + glm::length(bc + ca + ab));
  const double circum =
      glm::length(glm::dot(a, a) * bc + glm::dot(b, b) * ca + glm::dot(c, c) * ab);
  return circum > 0 ? 108 * volume * volume / (area * circum) : 0;
}

std::vector<glm::uvec4> ComputeNeighbors(std::span<const glm::uvec4> tets, size_t vertex_count,
                                         uint32_t faces_at_once) {
  TETREC_CHECK(tets.size() < (size_t{1} << 30), "4 faces per tet must fit into 32 bits");
  const std::vector<uint32_t> begin = FirstFaces(tets, vertex_count);
  // Some vertices at a time: entries of all faces would take three times as much memory as the
  // tets.
  const uint32_t faces_of_pass = std::max(faces_at_once, begin[vertex_count] / 4);
  std::vector<glm::uvec4> neighbors(tets.size(), glm::uvec4(kNoTet));
  for (size_t first = 0, last = 0; first < vertex_count; first = last) {
    do {
      ++last;
    } while (last < vertex_count && begin[last + 1] - begin[first] <= faces_of_pass);
    MatchFaces(tets, std::span(begin).subspan(first, last - first + 1), uint32_t(first), neighbors);
  }
  return neighbors;
}

void CheckTets(const TetMesh& mesh, Orientations expected) {
  CheckSizesAndIds(mesh);
  if (expected == Orientations::kPositive) CheckOrientations(mesh);
  CheckLinks(mesh);
  CheckAllReferenced(mesh);
}

void CheckTetMesh(const TetMesh& mesh, Orientations expected) {
  CheckTets(mesh, expected);
  CheckNoLinkMissing(mesh);
}

uint64_t CountDegenerateTets(const TetMesh& mesh) {
  uint64_t count = 0;
  for (const glm::uvec4& tet : mesh.tets) count += OrientationOf(mesh, tet) <= 0;
  return count;
}

void CheckConvexDomain(const TetMesh& mesh) {
  const std::string why = WhyNotConvex(mesh, BoundaryFaces(mesh));
  if (!why.empty()) {
    throw DataError(fmt::format(
        "{}: only tetrec-render accepts such a mesh; make another with tetrec-tetrahedralize",
        why));
  }
}

TetMeshQuality MeasureQuality(const TetMesh& mesh) {
  TetMeshQuality quality;
  if (mesh.tets.empty()) return quality;
  quality.min_radius_ratio = quality.min_volume = std::numeric_limits<double>::infinity();
  double ratio_sum = 0;
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    const double ratio = RadiusRatio(mesh, mesh.tets[t]);
    const double volume = TetVolume(mesh, mesh.tets[t]);
    quality.min_radius_ratio = std::min(quality.min_radius_ratio, ratio);
    quality.min_volume = std::min(quality.min_volume, volume);
    quality.total_volume += volume;
    ratio_sum += ratio;
    for (int i = 0; i < 4; ++i) quality.boundary_faces += mesh.neighbors[t][i] == kNoTet;
  }
  quality.mean_radius_ratio = ratio_sum / double(mesh.tets.size());
  quality.mean_volume = quality.total_volume / double(mesh.tets.size());
  return quality;
}

MeshOrder SortAlongMortonCurve(TetMesh& mesh) {
  std::vector<uint32_t> old_vertex =
      MortonOrder(mesh.positions.size(), [&](size_t v) { return mesh.positions[v]; });
  const std::vector<uint32_t> new_vertex = Inverse(old_vertex);
  std::vector<uint32_t> old_tet = MortonOrder(mesh.tets.size(), [&](size_t t) {
    // Adds quarters instead of dividing the sum, which overflows for huge coordinates.
    glm::vec3 center(0.0f);
    for (int i = 0; i < 4; ++i) center += 0.25f * mesh.positions[mesh.tets[t][i]];
    return center;
  });
  const std::vector<uint32_t> new_tet = Inverse(old_tet);

  TetMesh sorted;
  sorted.positions.resize(mesh.positions.size());
  for (size_t v = 0; v < old_vertex.size(); ++v)
    sorted.positions[v] = mesh.positions[old_vertex[v]];
  sorted.tets.resize(mesh.tets.size());
  sorted.neighbors.resize(mesh.neighbors.size());
  ParallelFor(old_tet.size(), kTetsPerTask, [&](size_t first, size_t last) {
    for (size_t t = first; t < last; ++t) {
      for (int i = 0; i < 4; ++i) sorted.tets[t][i] = new_vertex[mesh.tets[old_tet[t]][i]];
    }
  });
  ParallelFor(sorted.neighbors.size(), kTetsPerTask, [&](size_t first, size_t last) {
    for (size_t t = first; t < last; ++t) {
      for (int i = 0; i < 4; ++i) {
        const uint32_t neighbor = mesh.neighbors[old_tet[t]][i];
        sorted.neighbors[t][i] = neighbor == kNoTet ? kNoTet : new_tet[neighbor];
      }
    }
  });
  mesh = std::move(sorted);
  return {std::move(old_vertex), std::move(old_tet)};
}

}  // namespace tetrec
