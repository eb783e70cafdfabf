// A surface and its colours are fitted to the photos in turns.
#include "surface/align_with_photos.h"

#include "surface/photo_differences.h"
#include "surface/photo_moves.h"
#include "surface/surface_colors.h"

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
constexpr int kColorRounds = 1;

// How strongly a displacement follows its neighbours'. A higher value removes more ripples, and
// more details with them.
constexpr float kStiffness = 1;

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

struct ColoredMesh {
  TriangleMesh mesh;
  std::vector<glm::vec3> colors;  // [display sRGB, 0 to 1]
};

// Returns how the result differs from the photos.
PhotoDifferences FitTo(std::span<const TexturePhoto> photos, const SurfaceTopology& topology,
                       int rounds, ColoredMesh& surface) {
  ColoredMesh before;
  PhotoDifferences differences;
  for (int round = 0; round <= kColorRounds + rounds; ++round) {
    PhotoDifferences now = CompareWithPhotos(
        surface.mesh, topology.border, ColorsOfVertices(surface.mesh, surface.colors), photos);
    if (round > kColorRounds &&
        now.mean_squared_local_error > differences.mean_squared_local_error) {
      surface = std::move(before);
      break;
    }
    differences = std::move(now);
    before = surface;
    if (round == kColorRounds + rounds) break;
    CorrectColors(differences.vertices, surface.colors);
    if (round >= kColorRounds) {
      surface.mesh = MovedTowardsPhotos(before.mesh, topology, differences.vertices, kStiffness);
    }
  }
  return differences;
}

}  // namespace

AlignedSurface AlignWithPhotos(TriangleMesh start, std::span<const TexturePhoto> photos,
                               int rounds) {
  if (rounds == 0 || photos.size() < 2) return {.mesh = std::move(start)};
  const SurfaceTopology topology(start);
  ColoredMesh surface{start, VertexColors(start)};
  const PhotoDifferences differences = FitTo(photos, topology, rounds, surface);
  AlignedSurface result{.mesh = std::move(surface.mesh),
                        .mean_move_px = 0,
                        .error = std::sqrt(differences.mean_squared_error)};
  result.mean_move_px = MeanMove(start, result.mesh, differences.vertices);
  result.mesh.colors_srgb = Rounded(surface.colors);
  return result;
}

}  // namespace tetrec
