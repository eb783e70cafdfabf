// Gauss-Newton steps, with displacements that vary smoothly over the surface.
#include "surface/align_with_photos.h"

#include "surface/photo_differences.h"
#include "surface/step_back.h"
#include "surface/vertex_fans.h"
#include "surface/vertex_normals.h"

#include <glm/glm.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

// Rounds before the first move that only correct colours: a field's colours are those of its own
// vertices, not of its surface. All later rounds correct them, too.
constexpr int kColorRounds = 2;

// What pulls a displacement to the mean of its neighbours', and to 0, as the curvature of the error
// pulls it to where the photos want it. The former decides between details and ripples.
constexpr float kStiffness = 1, kRest = 0.02f;
constexpr int kRelaxations = 40;
constexpr float kLargestMove_px = 0.5f;  // of a round: pictures are linear over about a pixel

std::vector<glm::vec3> ColorsOf(const TriangleMesh& mesh) {
  if (mesh.colors_srgb.empty()) return std::vector(mesh.positions.size(), glm::vec3(0.5f));
  std::vector<glm::vec3> colors;
  for (const auto& rgb : mesh.colors_srgb) {
    colors.push_back(glm::vec3(rgb[0], rgb[1], rgb[2]) / 255.0f);
  }
  return colors;
}

std::vector<std::array<uint8_t, 3>> Rounded(std::span<const glm::vec3> colors) {
  std::vector<std::array<uint8_t, 3>> rounded;
  for (const glm::vec3& color : colors) {
    const glm::vec3 rgb = glm::round(255.0f * glm::clamp(color, 0.0f, 1.0f));
    rounded.push_back({uint8_t(rgb.x), uint8_t(rgb.y), uint8_t(rgb.z)});
  }
  return rounded;
}

// Adds the mean error of the pixels that show a vertex to its colour.
void CorrectColors(std::span<const VertexDifferences> differences, std::vector<glm::vec3>& colors) {
  for (size_t v = 0; v < colors.size(); ++v) {
    const VertexDifferences& d = differences[v];
    if (d.color_weight > 0) colors[v] += d.color_error / d.color_weight;
  }
}

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
                                     std::span<const VertexDifferences> differences) {
  std::vector<glm::mat3> inverse;
  for (const VertexDifferences& d : differences) {
    inverse.push_back(glm::inverse(d.curvature + glm::mat3(kStiffness + kRest)));
  }
  std::vector<glm::vec3> displacements(differences.size(), glm::vec3(0.0f));
  for (int round = 0; round < kRelaxations; ++round) {
    for (size_t v = 0; v < displacements.size(); ++v) {
      const std::span<const uint32_t> fan = fans.At(v);
      if (fan.empty()) continue;
      displacements[v] =
          inverse[v] * (differences[v].pull + kStiffness * MeanAround(v, mesh, fan, displacements));
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

TriangleMesh Moved(const TriangleMesh& mesh, const VertexFans& fans,
                   const std::vector<bool>& border,
                   std::span<const VertexDifferences> differences) {
  const std::vector<glm::vec3> displacements = Displacements(mesh, fans, differences);
  const std::vector<float> footprints = FootprintsOf(differences);
  TriangleMesh moved = mesh;
  for (size_t v = 0; v < displacements.size(); ++v) {
    if (border[v]) continue;
    const float length = glm::length(displacements[v]);
    const float shortened = length > kLargestMove_px ? kLargestMove_px / length : 1.0f;
    moved.positions[v] += footprints[v] * shortened * displacements[v];
  }
  UndoFolds(mesh, moved);
  return moved;
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

struct ColoredMesh {
  TriangleMesh mesh;
  std::vector<glm::vec3> colors;  // [display sRGB, 0 to 1]
};

// Returns how the result differs from the photos.
PhotoDifferences FitTo(std::span<const TexturePhoto> photos, const VertexFans& fans,
                       const std::vector<bool>& border, int rounds, ColoredMesh& surface) {
  ColoredMesh before;
  PhotoDifferences differences;
  for (int round = 0; round <= kColorRounds + rounds; ++round) {
    PhotoDifferences now = CompareWithPhotos(surface.mesh, border, surface.colors, photos);
    if (round > kColorRounds && now.mean_squared_error > differences.mean_squared_error) {
      surface = std::move(before);
      break;
    }
    differences = std::move(now);
    before = surface;
    if (round == kColorRounds + rounds) break;
    CorrectColors(differences.vertices, surface.colors);
    if (round >= kColorRounds) {
      surface.mesh = StepBackFromCrossings(before.mesh,
                                           Moved(before.mesh, fans, border, differences.vertices));
    }
  }
  return differences;
}

}  // namespace

AlignedSurface AlignWithPhotos(TriangleMesh start, std::span<const TexturePhoto> photos,
                               int rounds) {
  if (rounds == 0 || photos.size() < 2) return {.mesh = std::move(start)};
  const VertexFans fans(start);
  const std::vector<bool> border = BorderVertices(start);
  ColoredMesh surface{start, ColorsOf(start)};
  const PhotoDifferences differences = FitTo(photos, fans, border, rounds, surface);
  AlignedSurface result{.mesh = std::move(surface.mesh),
                        .mean_move_px = 0,
                        .error = std::sqrt(differences.mean_squared_error)};
  result.mean_move_px = MeanMove(start, result.mesh, differences.vertices);
  result.mesh.colors_srgb = Rounded(surface.colors);
  return result;
}

}  // namespace tetrec
