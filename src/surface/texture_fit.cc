// Back-projection of the errors of pixels, and Gauss-Newton steps of vertices.
#include "surface/texture_fit.h"

#include "core/parallel.h"
#include "image/pixels_around.h"
#include "surface/continue_colors.h"
#include "surface/draw_surface.h"
#include "surface/photo_moves.h"
#include "surface/sighting.h"
#include "surface/texels.h"
#include "surface/trained_views.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

namespace tetrec {
namespace {

constexpr int kRoundsWithoutMoves = 3;
// With moves, some rounds only correct texels: one before the moves, so that they do not follow the
// blur of the baked texture, and one after them, because the texture then still fits where the
// surface was.
constexpr int kRoundsBeforeMoves = 1, kRoundsAfterMoves = 1;

// The stiffness is lower than in AlignWithPhotos, because ripples come from detail that the colours
// of vertices cannot show, and a texture can.
constexpr float kTexturedStiffness = 0.3f;

struct WeightedSum {
  glm::dvec3 sum{0.0};
  double weight = 0;
};

// Adds the errors of those pixels around a position that show nothing but the surface. Pixels near
// outlines count less, because surface and photo rarely agree there on what is in front.
void AddError(const TexturePhoto& photo, const SurfacePicture& drawn, const Sighting& sighting,
              WeightedSum& error) {
  const double pixels_per_area = sighting.facing / (sighting.footprint * sighting.footprint);
  glm::dvec3 colors(0.0), drawn_colors(0.0);
  double weights = 0;
  for (const auto& [x, y, weight] :
       PixelsAround(photo.camera.width, photo.camera.height, sighting.pixel)) {
    if (weight == 0) continue;
    const size_t i = photo.Index(x, y);
    if (!drawn.covered[i] || !photo.Counts(x, y)) continue;
    const double worth = pixels_per_area * weight * (1 + photo.trust[i]);
    const uint8_t *rgb = photo.image.At(x, y), *drawn_rgb = drawn.image.At(x, y);
    colors += worth * glm::dvec3(rgb[0], rgb[1], rgb[2]);
    drawn_colors += worth * glm::dvec3(drawn_rgb[0], drawn_rgb[1], drawn_rgb[2]);
    weights += worth;
  }
  if (!(weights > 0)) return;
  error.sum += weights * photo.WithoutExposure(colors / weights) - drawn_colors / 255.0;
  error.weight += weights;
}

// All must outlive this. FindTrust must have seen the mesh, which may have moved by less since than
// the tolerance of TexturePhoto::ShowsPoint.
class TexelCorrections {
 public:
  TexelCorrections(const TriangleMesh& mesh, const TextureLayout& layout, const Texels& texels,
                   std::span<const TexturePhoto> photos)
      : layout_(layout),
        texels_(texels),
        photos_(photos),
        candidates_(PhotosOfTriangles(mesh, photos)) {}

  // `drawn` are the pictures of the mesh in the colours of the texture.
  void Correct(const TriangleMesh& mesh, const std::vector<SurfacePicture>& drawn,
               Image& texture) const {
    const SurfacePoints surface(mesh);
    ParallelFor(size_t(layout_.size), 8, [&](size_t begin, size_t end) {
      for (size_t y = begin; y < end; ++y) {
        for (int x = 0; x < layout_.size; ++x) {
          const uint32_t triangle = texels_.triangle[y * size_t(layout_.size) + size_t(x)];
          if (triangle == kNoTriangle) continue;
          const SurfacePoint point = surface.At(
              triangle, NearestWeights(layout_.corners[triangle], glm::dvec2(x, double(y)) + 0.5));
          WeightedSum error;
          for (const uint32_t id : candidates_.photos[triangle]) {
            if (const auto sighting = See(point, photos_[id])) {
              AddError(photos_[id], drawn[id], *sighting, error);
            }
          }
          if (!(error.weight > 0)) continue;
          uint8_t* rgb = texture.At(x, int(y));
          for (int c = 0; c < 3; ++c) {
            rgb[c] = uint8_t(
                std::lround(std::clamp(rgb[c] + 255 * error.sum[c] / error.weight, 0.0, 255.0)));
          }
        }
      }
    });
  }

 private:
  const TextureLayout& layout_;
  const Texels& texels_;
  std::span<const TexturePhoto> photos_;
  PhotosByTriangle candidates_;
};

void CorrectTexels(const TriangleMesh& mesh, const TexelCorrections& corrections,
                   std::span<const TexturePhoto> photos, int rounds, Image& texture) {
  std::vector<SurfacePicture> drawn(photos.size());
  for (int round = 0; round < rounds; ++round) {
    ParallelForEach(photos.size(), "", kAfterASurfaceStop, [&](size_t i) {
      drawn[i] = DrawSurface(mesh, texture, photos[i].camera, photos[i].cam_from_world);
    });
    corrections.Correct(mesh, drawn, texture);
  }
}

TextureFit MoveAndCorrect(TriangleMesh& mesh, const TexelCorrections& corrections,
                          std::span<const TexturePhoto> photos, int moves, Image& texture) {
  const TriangleMesh start = mesh;
  const SurfaceTopology topology(mesh);
  TriangleMesh mesh_before;
  Image texture_before;
  PhotoDifferences differences;
  std::vector<SurfacePicture> drawn(photos.size());
  for (int move = 0; move <= moves; ++move) {
    PhotoDifferences now =
        CompareWithPhotos(mesh, topology.border, ColorsOfTexture(mesh, texture), photos, drawn);
    if (move > 0 && now.mean_squared_local_error > differences.mean_squared_local_error) {
      mesh = std::move(mesh_before);
      texture = std::move(texture_before);
      break;
    }
    differences = std::move(now);
    mesh_before = mesh;
    texture_before = texture;
    corrections.Correct(mesh_before, drawn, texture);
    if (move == moves) break;
    mesh = MovedTowardsPhotos(mesh_before, topology, differences.vertices, kTexturedStiffness);
  }
  return {MeanMove(start, mesh, differences.vertices), std::sqrt(differences.mean_squared_error)};
}

}  // namespace

TextureFit FitTexture(TriangleMesh& mesh, const TextureLayout& layout,
                      std::span<const TexturePhoto> photos, int moves, Image& texture) {
  const Texels texels = FindTexels(layout);
  const TexelCorrections corrections(mesh, layout, texels, photos);
  TextureFit fit;
  if (moves == 0 || photos.size() < 2) {
    CorrectTexels(mesh, corrections, photos, kRoundsWithoutMoves, texture);
  } else {
    CorrectTexels(mesh, corrections, photos, kRoundsBeforeMoves, texture);
    fit = MoveAndCorrect(mesh, corrections, photos, moves, texture);
    CorrectTexels(mesh, corrections, photos, kRoundsAfterMoves, texture);
  }
  ContinueColors(texture, [&](size_t i) { return texels.triangle[i] != kNoTriangle; });
  return fit;
}

}  // namespace tetrec
