// Bilateral filtering of normals, and vertices that follow.
#include "surface/smooth.h"

#include "surface/step_back.h"
#include "surface/vertex_normals.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

constexpr int kVertexRounds = 20;  // in which vertices follow the normals

// The triangles at each vertex, one list after the other.
struct Fans {
  std::vector<uint32_t> begin, triangles;  // (V + 1), (3 M)
};

Fans FansOf(const TriangleMesh& mesh) {
  Fans fans{std::vector<uint32_t>(mesh.positions.size() + 1, 0), {}};
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++fans.begin[t[k] + 1];
  }
  for (size_t v = 1; v < fans.begin.size(); ++v) fans.begin[v] += fans.begin[v - 1];
  fans.triangles.resize(3 * mesh.triangles.size());
  std::vector<uint32_t> next(fans.begin.begin(), fans.begin.end() - 1);
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) fans.triangles[next[mesh.triangles[t][k]]++] = t;
  }
  return fans;
}

// Those of edges that only one triangle has.
std::vector<bool> BorderVertices(const TriangleMesh& mesh) {
  std::vector<std::pair<uint32_t, uint32_t>> edges;
  for (const glm::uvec3& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) edges.push_back(std::minmax({t[k], t[(k + 1) % 3]}));
  }
  std::sort(edges.begin(), edges.end());
  std::vector<bool> border(mesh.positions.size(), false);
  for (size_t e = 0; e < edges.size();) {
    size_t end = e + 1;
    while (end < edges.size() && edges[end] == edges[e]) ++end;
    if (end - e == 1) border[edges[e].first] = border[edges[e].second] = true;
    e = end;
  }
  return border;
}

std::vector<glm::dvec3> FilteredNormals(const TriangleMesh& mesh, const Fans& fans,
                                        const SmoothOptions& options) {
  std::vector<glm::dvec3> normals;
  std::vector<double> areas;
  for (const glm::uvec3& t : mesh.triangles) {
    const glm::dvec3 normal = DoubleAreaNormal(mesh, t);
    areas.push_back(glm::length(normal));
    normals.push_back(areas.back() > 0 ? normal / areas.back() : normal);
  }
  const double per_squared = -0.5 / (options.edge_width * options.edge_width);
  for (int round = 0; round < options.rounds; ++round) {
    std::vector<glm::dvec3> filtered = normals;
    for (size_t t = 0; t < normals.size(); ++t) {
      glm::dvec3 sum(0.0);
      for (int k = 0; k < 3; ++k) {
        const uint32_t v = mesh.triangles[t][k];
        for (uint32_t i = fans.begin[v]; i < fans.begin[v + 1]; ++i) {
          const uint32_t other = fans.triangles[i];
          const glm::dvec3 difference = normals[other] - normals[t];
          sum += areas[other] * std::exp(per_squared * glm::dot(difference, difference)) *
                 normals[other];
        }
      }
      const double length = glm::length(sum);
      if (length > 0) filtered[t] = sum / length;
    }
    normals = std::move(filtered);
  }
  return normals;
}

}  // namespace

TriangleMesh SmoothByNormals(TriangleMesh mesh, const SmoothOptions& options) {
  if (options.rounds == 0 || !(options.max_move > 0)) return mesh;
  const Fans fans = FansOf(mesh);
  const std::vector<bool> border = BorderVertices(mesh);
  const std::vector<glm::dvec3> normals = FilteredNormals(mesh, fans, options);
  const std::vector<glm::dvec3> start(mesh.positions.begin(), mesh.positions.end());
  std::vector<glm::dvec3> positions = start;
  for (int round = 0; round < kVertexRounds; ++round) {
    std::vector<glm::dvec3> centers;
    for (const glm::uvec3& t : mesh.triangles) {
      centers.push_back((positions[t.x] + positions[t.y] + positions[t.z]) / 3.0);
    }
    for (size_t v = 0; v < positions.size(); ++v) {
      const uint32_t count = fans.begin[v + 1] - fans.begin[v];
      if (border[v] || count == 0) continue;
      glm::dvec3 move(0.0);
      for (uint32_t i = fans.begin[v]; i < fans.begin[v + 1]; ++i) {
        const uint32_t t = fans.triangles[i];
        move += normals[t] * glm::dot(normals[t], centers[t] - positions[v]);
      }
      glm::dvec3 offset = positions[v] + move / double(count) - start[v];
      const double length = glm::length(offset);
      if (length > options.max_move) offset *= options.max_move / length;
      positions[v] = start[v] + offset;
    }
  }
  TriangleMesh moved = mesh;
  for (size_t v = 0; v < positions.size(); ++v) moved.positions[v] = glm::vec3(positions[v]);
  return StepBackFromCrossings(mesh, std::move(moved));
}

}  // namespace tetrec
