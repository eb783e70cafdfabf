// Bilateral filtering of normals, and vertices that follow.
#include "surface/smooth.h"

#include "core/parallel.h"
#include "surface/step_back.h"
#include "surface/vertex_fans.h"
#include "surface/vertex_normals.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace tetrec {
namespace {

constexpr int kVertexRounds = 20;  // in which vertices follow the normals
constexpr size_t kVerticesPerTask = 4096;

std::vector<glm::dvec3> FilteredNormals(const TriangleMesh& mesh, const VertexFans& fans,
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
    ParallelFor(normals.size(), kVerticesPerTask, [&](size_t begin, size_t end) {
      for (size_t t = begin; t < end; ++t) {
        glm::dvec3 sum(0.0);
        for (int k = 0; k < 3; ++k) {
          for (const uint32_t other : fans.At(mesh.triangles[t][k])) {
            const glm::dvec3 difference = normals[other] - normals[t];
            sum += areas[other] * std::exp(per_squared * glm::dot(difference, difference)) *
                   normals[other];
          }
        }
        const double length = glm::length(sum);
        if (length > 0) filtered[t] = sum / length;
      }
    });
    normals = std::move(filtered);
  }
  return normals;
}

}  // namespace

TriangleMesh SmoothByNormals(TriangleMesh mesh, const SmoothOptions& options) {
  if (options.rounds == 0 || !(options.max_move > 0)) return mesh;
  const VertexFans fans(mesh);
  const std::vector<bool> border = BorderVertices(mesh);
  const std::vector<glm::dvec3> normals = FilteredNormals(mesh, fans, options);
  const std::vector<glm::dvec3> start(mesh.positions.begin(), mesh.positions.end());
  std::vector<glm::dvec3> positions = start;
  for (int round = 0; round < kVertexRounds; ++round) {
    std::vector<glm::dvec3> centers;
    for (const glm::uvec3& t : mesh.triangles) {
      centers.push_back((positions[t.x] + positions[t.y] + positions[t.z]) / 3.0);
    }
    ParallelFor(positions.size(), kVerticesPerTask, [&](size_t begin, size_t end) {
      for (size_t v = begin; v < end; ++v) {
        if (border[v] || fans.At(v).empty()) continue;
        glm::dvec3 move(0.0);
        for (const uint32_t t : fans.At(v)) {
          move += normals[t] * glm::dot(normals[t], centers[t] - positions[v]);
        }
        glm::dvec3 offset = positions[v] + move / double(fans.At(v).size()) - start[v];
        const double length = glm::length(offset);
        if (length > options.max_move) offset *= options.max_move / length;
        positions[v] = start[v] + offset;
      }
    });
  }
  TriangleMesh moved = mesh;
  for (size_t v = 0; v < positions.size(); ++v) moved.positions[v] = glm::vec3(positions[v]);
  return StepBackFromCrossings(mesh, std::move(moved));
}

}  // namespace tetrec
