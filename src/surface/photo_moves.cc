// Gauss-Newton steps, with displacements that vary smoothly over the surface.
#include "surface/photo_moves.h"

#include "surface/step_back.h"
#include "surface/vertex_normals.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <utility>

namespace tetrec {
namespace {

// Pulls a displacement to 0, so that what no photo decides stays.
constexpr float kRest = 0.02f;
constexpr int kRelaxations = 40;
constexpr float kLargestMove_px = 0.5f;  // pictures are linear over about a pixel

// The mean over the other corners of a vertex's triangles.
glm::vec3 MeanAround(size_t v, const TriangleMesh& mesh, std::span<const uint32_t> fan,
                     const std::vector<glm::vec3>& values) {
  glm::vec3 sum(0.0f);
  for (const uint32_t t : fan) {
    const glm::uvec3& corners = mesh.triangles[t];
    sum += values[corners.x] + values[corners.y] + values[corners.z] - values[v];
  }
  return sum / (2 * float(fan.size()));
}

// The displacements of least error [footprints], by Gauss-Seidel.
std::vector<glm::vec3> Displacements(const TriangleMesh& mesh, const VertexFans& fans,
                                     std::span<const VertexDifferences> differences,
                                     float stiffness) {
  std::vector<glm::mat3> inverse;
  for (const VertexDifferences& d : differences) {
    inverse.push_back(glm::inverse(d.curvature + glm::mat3(stiffness + kRest)));
  }
  std::vector<glm::vec3> displacements(differences.size(), glm::vec3(0.0f));
  for (int round = 0; round < kRelaxations; ++round) {
    for (size_t v = 0; v < displacements.size(); ++v) {
      const std::span<const uint32_t> fan = fans.At(v);
      if (fan.empty()) continue;
      displacements[v] =
          inverse[v] * (differences[v].pull + stiffness * MeanAround(v, mesh, fan, displacements));
    }
  }
  return displacements;
}

// The footprints of the pixels that show each vertex [world units]; a vertex that no photo sees has
// the mean of the others.
std::vector<float> FootprintsOf(std::span<const VertexDifferences> differences) {
  double sum = 0, seen = 0;
  for (const VertexDifferences& d : differences) sum += double(d.footprint), seen += double(d.seen);
  std::vector<float> footprints;
  for (const VertexDifferences& d : differences) {
    footprints.push_back(d.seen > 0 ? d.footprint / d.seen : seen > 0 ? float(sum / seen) : 0.0f);
  }
  return footprints;
}

// Takes the corners of triangles that a move turns over back to where they were.
void UndoFolds(const TriangleMesh& before, TriangleMesh& after) {
  bool found = true;  // then a corner goes back that has moved, so this ends
  while (found) {
    found = false;
    for (const glm::uvec3& t : before.triangles) {
      if (!(glm::dot(DoubleAreaNormal(before, t), DoubleAreaNormal(after, t)) < 0)) continue;
      for (int k = 0; k < 3; ++k) after.positions[t[k]] = before.positions[t[k]];
      found = true;
    }
  }
}

}  // namespace

TriangleMesh MovedTowardsPhotos(const TriangleMesh& mesh, const SurfaceTopology& topology,
                                std::span<const VertexDifferences> differences, float stiffness) {
  const std::vector<glm::vec3> displacements =
      Displacements(mesh, topology.fans, differences, stiffness);
  const std::vector<float> footprints = FootprintsOf(differences);
  TriangleMesh moved = mesh;
  for (size_t v = 0; v < displacements.size(); ++v) {
    if (topology.border[v]) continue;
    const float length = glm::length(displacements[v]);
    const float shortened = length > kLargestMove_px ? kLargestMove_px / length : 1.0f;
    moved.positions[v] += footprints[v] * shortened * displacements[v];
  }
  UndoFolds(mesh, moved);
  return StepBackFromCrossings(mesh, std::move(moved));
}

double MeanMove(const TriangleMesh& from, const TriangleMesh& to,
                std::span<const VertexDifferences> differences) {
  const std::vector<float> footprints = FootprintsOf(differences);
  double sum = 0, seen = 0;
  for (size_t v = 0; v < footprints.size(); ++v) {
    if (!(differences[v].seen > 0)) continue;
    sum += double(glm::distance(from.positions[v], to.positions[v]) / footprints[v]);
    seen += 1;
  }
  return seen > 0 ? sum / seen : 0;
}

}  // namespace tetrec
