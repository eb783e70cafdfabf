// The order in which the tets of a mesh are seen from a point.
#include "render/vulkan/visibility_order.h"

#include "geometry/bounds3.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetrec {
namespace {

using glm::dvec3;
using glm::dvec4;

// Centre | power of the origin. With edges e_i from p0: centre - p0 =
// (|e1|^2 e2 x e3 + |e2|^2 e3 x e1 + |e3|^2 e1 x e2) / (2 det), and |c|^2 - r^2 = 2 c.p0 - |p0|^2.
dvec4 Circumsphere(const TetMesh& mesh, const glm::uvec4& tet, const dvec3& origin) {
  const dvec3 p0 = dvec3(mesh.positions[tet[0]]) - origin;
  const dvec3 e1 = dvec3(mesh.positions[tet[1]]) - origin - p0;
  const dvec3 e2 = dvec3(mesh.positions[tet[2]]) - origin - p0;
  const dvec3 e3 = dvec3(mesh.positions[tet[3]]) - origin - p0;
  const dvec3 c23 = glm::cross(e2, e3), c31 = glm::cross(e3, e1), c12 = glm::cross(e1, e2);
  const dvec3 center =
      p0 + (glm::dot(e1, e1) * c23 + glm::dot(e2, e2) * c31 + glm::dot(e3, e3) * c12) /
               (2.0 * glm::dot(e1, c23));
  return {center, 2.0 * glm::dot(center, p0) - glm::dot(p0, p0)};
}

// Volume of (a, b, c, p) times 6: positive on the side to which the normal (b - a) x (c - a)
// points.
double SideOf(const dvec3& a, const dvec3& b, const dvec3& c, const dvec3& p) {
  return glm::dot(glm::cross(b - a, c - a), p - a);
}

// Calls body(InnerFace) once for every inner face.
template <class Body>
void ForEachInnerFace(const TetMesh& mesh, const Body& body) {
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    for (int face = 0; face < 4; ++face) {
      const uint32_t neighbor = mesh.neighbors[t][face];
      if (neighbor != kNoTet && t < neighbor) body(InnerFace{t, face, neighbor});
    }
  }
}

struct Triangle {
  dvec3 a, b, c;  // seen from outside the tet counterclockwise
};

Triangle TriangleOf(const TetMesh& mesh, const InnerFace& face) {
  const auto at = [&](int i) {
    return dvec3(mesh.positions[mesh.tets[face.tet][kFaceVertices[face.face][i]]]);
  };
  return {at(0), at(1), at(2)};
}

// Calls body(nearer, farther) with the tets of a face as seen from the eye; not if the eye is in
// the plane of the face, which then hides nothing.
template <class Body>
void CallNearFar(const TetMesh& mesh, const InnerFace& face, const dvec3& eye, const Body& body) {
  const Triangle triangle = TriangleOf(mesh, face);
  const double side = SideOf(triangle.a, triangle.b, triangle.c, eye);
  if (side < 0.0) body(face.tet, face.neighbor);
  if (side > 0.0) body(face.neighbor, face.tet);
}

// Tets joined by tied faces get the sphere of the first of them.
void ShareSpheres(PowerOrder& order) {
  std::vector<uint32_t> first(order.spheres.size());
  std::iota(first.begin(), first.end(), 0u);
  const auto find = [&first](uint32_t t) {
    while (first[t] != t) t = first[t] = first[first[t]];
    return t;
  };
  for (const InnerFace& face : order.tied_faces) {
    const uint32_t a = find(face.tet), b = find(face.neighbor);
    first[std::max(a, b)] = std::min(a, b);
  }
  for (uint32_t t = 0; t < first.size(); ++t) order.spheres[t] = order.spheres[find(t)];
}

std::vector<uint32_t> ByCentroidDistance(const TetMesh& mesh, const dvec3& eye) {
  std::vector<double> distance;
  for (const glm::uvec4& tet : mesh.tets) {
    dvec3 centroid(0.0);
    for (int i = 0; i < 4; ++i) centroid += 0.25 * dvec3(mesh.positions[tet[i]]);
    distance.push_back(glm::distance(centroid, eye));
  }
  std::vector<uint32_t> order(mesh.tets.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](uint32_t a, uint32_t b) { return distance[a] < distance[b]; });
  return order;
}

// The longest path to each tet, from tet to farther tet over the faces with which `for_each_face`
// calls its argument. If the faces form a cycle, the nearest waiting tet is let through, followed
// by those that it releases.
template <class ForEachFace>
VisibilityRanks RankOver(const TetMesh& mesh, const ForEachFace& for_each_face, const dvec3& eye) {
  const size_t tets = mesh.tets.size();
  std::vector<uint8_t> waits_for(tets, 0);  // nearer neighbours that are not ranked yet
  std::vector<uint32_t> behind(4 * tets);   // farther neighbours, up to four per tet
  std::vector<uint8_t> behind_count(tets, 0);
  for_each_face([&](const InnerFace& face) {
    CallNearFar(mesh, face, eye, [&](uint32_t nearer, uint32_t farther) {
      behind[4 * size_t(nearer) + behind_count[nearer]++] = farther;
      ++waits_for[farther];
    });
  });
  VisibilityRanks result;
  result.ranks.assign(tets, 0);
  std::vector<bool> is_ranked(tets, false);
  std::vector<uint32_t> ready;
  for (uint32_t t = 0; t < tets; ++t) {
    if (waits_for[t] == 0) ready.push_back(t);
  }
  size_t ranked = 0;
  const auto rank_ready = [&] {
    while (!ready.empty()) {
      const uint32_t t = ready.back();
      ready.pop_back();
      is_ranked[t] = true;
      ++ranked;
      for (int i = 0; i < behind_count[t]; ++i) {
        const uint32_t next = behind[4 * size_t(t) + i];
        if (is_ranked[next]) continue;  // let through before
        result.ranks[next] = std::max(result.ranks[next], result.ranks[t] + 1);
        if (--waits_for[next] == 0) ready.push_back(next);
      }
    }
  };
  rank_ready();
  if (ranked == tets) return result;
  for (uint32_t t : ByCentroidDistance(mesh, eye)) {
    if (is_ranked[t]) continue;
    ++result.tets_in_cycles;
    ready.push_back(t);
    rank_ready();
  }
  return result;
}

}  // namespace

PowerOrder MeasurePowerOrder(const TetMesh& mesh) {
  const Bounds3 bounds = BoundsOf(mesh.positions);
  PowerOrder order;
  order.origin = bounds.Center();
  const double extent = bounds.Diagonal();
  for (const glm::uvec4& tet : mesh.tets) {
    order.spheres.push_back(Circumsphere(mesh, tet, order.origin));
  }
  // Seen from an eye at distance d from the shared face's plane, the keys of its tets differ by
  // 2 |c' - c| d. The error of the device's pairs of floats is about 2^-44 of the terms of a key.
  // With this margin they are sorted correctly for every eye within four extents that is at least
  // 1/1000 of the extent away from the plane (closer than that, hardly any ray passes both tets).
  constexpr double kPairRounding = 0x1p-44, kNearestPlane = 1e-3, kFarthestEye = 4.0;
  ForEachInnerFace(mesh, [&](const InnerFace& face) {
    const Triangle triangle = TriangleOf(mesh, face);
    const dvec3 outward =
        glm::normalize(glm::cross(triangle.b - triangle.a, triangle.c - triangle.a));
    const dvec4& here = order.spheres[face.tet];
    const dvec4& there = order.spheres[face.neighbor];
    // Centres of Delaunay neighbours lie along the normal in the order of the tets.
    const double gap = 2.0 * kNearestPlane * extent * glm::dot(dvec3(there) - dvec3(here), outward);
    const double term =
        std::max(std::abs(here.w), std::abs(there.w)) +
        2.0 * kFarthestEye * extent * std::max(glm::length(dvec3(here)), glm::length(dvec3(there)));
    const bool in_range = term < 1e30;  // of floats
    if (in_range && std::abs(gap) <= kPairRounding * term) {
      order.tied_faces.push_back(face);
    } else if (!in_range || gap < 0.0) {
      ++order.bad_faces;
    }
  });
  ShareSpheres(order);
  return order;
}

VisibilityRanks RankTies(const TetMesh& mesh, const PowerOrder& order, const glm::vec3& eye) {
  if (order.tied_faces.empty()) return {};
  const auto for_each_tie = [&](const auto& body) {
    for (const InnerFace& face : order.tied_faces) body(face);
  };
  return RankOver(mesh, for_each_tie, dvec3(eye));
}

VisibilityRanks RankByVisibility(const TetMesh& mesh, const glm::vec3& eye) {
  return RankOver(
      mesh, [&](const auto& body) { ForEachInnerFace(mesh, body); }, dvec3(eye));
}

}  // namespace tetrec
