// Back-projection of the errors of pixels.
#include "surface/texture_fit.h"

#include "core/parallel.h"
#include "image/pixels_around.h"
#include "surface/continue_colors.h"
#include "surface/draw_surface.h"
#include "surface/sighting.h"
#include "surface/texels.h"
#include "surface/trained_views.h"

#include <glm/glm.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace tetrec {
namespace {

constexpr int kRounds = 3;

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

}  // namespace

void FitTexture(const TriangleMesh& mesh, const TextureLayout& layout,
                std::span<const TexturePhoto> photos, Image& texture) {
  const Texels texels = FindTexels(layout);
  const SurfacePoints surface(mesh);
  const PhotosByTriangle candidates = PhotosOfTriangles(mesh, photos);
  std::vector<SurfacePicture> drawn(photos.size());
  for (int round = 0; round < kRounds; ++round) {
    ParallelForEach(photos.size(), "", kAfterASurfaceStop, [&](size_t i) {
      drawn[i] = DrawSurface(mesh, texture, photos[i].camera, photos[i].cam_from_world);
    });
    ParallelFor(size_t(layout.size), 8, [&](size_t begin, size_t end) {
      for (size_t y = begin; y < end; ++y) {
        for (int x = 0; x < layout.size; ++x) {
          const uint32_t triangle = texels.triangle[y * size_t(layout.size) + size_t(x)];
          if (triangle == kNoTriangle) continue;
          const SurfacePoint point = surface.At(
              triangle, NearestWeights(layout.corners[triangle], glm::dvec2(x, double(y)) + 0.5));
          WeightedSum error;
          for (const uint32_t id : candidates.photos[triangle]) {
            if (const auto sighting = See(point, photos[id])) {
              AddError(photos[id], drawn[id], *sighting, error);
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
  ContinueColors(texture, [&](size_t i) { return texels.triangle[i] != kNoTriangle; });
}

}  // namespace tetrec
