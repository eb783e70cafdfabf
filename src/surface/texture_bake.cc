// Points on the surface, the photos that see them, and their mean.
#include "surface/texture_bake.h"

#include "core/parallel.h"
#include "core/quantile.h"
#include "image/pixels_around.h"
#include "surface/sighting.h"
#include "surface/texels.h"
#include "surface/vertex_normals.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace tetrec {
namespace {

constexpr size_t kBlended = 3;  // photos that a texel is the mean of
// A texel whose best photo counts less than this is partly of the vertices' colour.
constexpr double kDecidingQuality = 0.1;

// A photo in which a point is seen, and what it is worth.
struct Choice {
  double weight = 0;   // squared pixels per unit of area, times quality
  double quality = 0;  // 1: from the front and far from outlines, 0: not seen
  Sighting sighting;
  uint32_t photo = 0;
};

Choice Judge(const SurfacePoint& point, const TexturePhoto& photo, uint32_t id) {
  const std::optional<Sighting> seen = See(point, photo);
  if (!seen) return {};
  double trust = 0;
  for (const auto& [x, y, weight] :
       PixelsAround(photo.camera.width, photo.camera.height, seen->pixel)) {
    if (weight > 0) trust += weight * double(photo.trust[photo.Index(x, y)]) / kFullTrust;
  }
  const double quality = trust * seen->facing * seen->facing;
  return {quality / (seen->footprint * seen->footprint), quality, *seen, id};
}

// The colour at a pixel position. At least one of the pixels around it must show the surface.
glm::dvec3 ColorAt(const TexturePhoto& photo, const glm::dvec2& pixel) {
  glm::dvec3 color(0.0);
  double weights = 0;
  for (const auto& [x, y, weight] : PixelsAround(photo.camera.width, photo.camera.height, pixel)) {
    if (weight == 0 || photo.Hides(x, y)) continue;
    const uint8_t* rgb = photo.image.At(x, y);
    color += weight * glm::dvec3(rgb[0], rgb[1], rgb[2]);
    weights += weight;
  }
  return photo.WithoutExposure(color / weights);
}

// The mean of the best photos, over the color that is taken where none sees the point well.
struct Blend {
  glm::dvec3 color{0.0};
  double seen = 0;  // share that photos decide
};

Blend BlendPhotos(const SurfacePoint& point, std::span<const TexturePhoto> photos,
                  std::span<const uint32_t> candidates, const glm::dvec3& unseen) {
  std::array<Choice, kBlended + 1> best{};  // from the best one on
  for (const uint32_t id : candidates) {
    Choice choice = Judge(point, photos[id], id);
    for (Choice& other : best) {
      if (choice.weight > other.weight) std::swap(choice, other);
    }
  }
  glm::dvec3 sum(0.0);
  double weights = 0;
  for (size_t i = 0; i < kBlended; ++i) {
    const double weight = best[i].weight - best[kBlended].weight;
    if (!(weight > 0)) break;
    sum += weight * ColorAt(photos[best[i].photo], best[i].sighting.pixel);
    weights += weight;
  }
  if (!(weights > 0)) {
    // Photos that are worth the same, or none.
    if (!(best[0].weight > 0)) return {unseen, 0};
    sum = ColorAt(photos[best[0].photo], best[0].sighting.pixel);
    weights = 1;
  }
  const double seen = std::min(1.0, best[0].quality / kDecidingQuality);
  return {glm::mix(unseen, sum / weights, seen), seen};
}

}  // namespace

double MedianFootprint(const TriangleMesh& mesh, std::span<const TexturePhoto> photos) {
  const SurfacePoints surface(mesh);
  const PhotosByTriangle candidates = PhotosOfTriangles(mesh, photos);
  std::vector<std::pair<double, double>> footprints;  // with areas
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const SurfacePoint center = surface.At(uint32_t(t), glm::dvec3(1.0 / 3));
    Choice best;
    for (const uint32_t id : candidates.photos[t]) {
      const Choice choice = Judge(center, photos[id], id);
      if (choice.weight > best.weight) best = choice;
    }
    if (best.weight > 0) {
      footprints.emplace_back(best.sighting.footprint,
                              glm::length(DoubleAreaNormal(mesh, mesh.triangles[t])));
    }
  }
  return footprints.empty() ? 0 : WeightedQuantile(std::move(footprints), 0.5);
}

BakedTexture BakeTexture(const TriangleMesh& mesh, const TextureLayout& layout,
                         std::span<const TexturePhoto> photos) {
  const Texels texels = FindTexels(layout);
  const SurfacePoints surface(mesh);
  const PhotosByTriangle candidates = PhotosOfTriangles(mesh, photos);
  BakedTexture baked{MakeImage(layout.size, layout.size, 3), 0, candidates.limited};
  std::vector<double> seen_in_row(size_t(layout.size), 0), texels_in_row = seen_in_row;
  ParallelFor(size_t(layout.size), 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (int x = 0; x < layout.size; ++x) {
        const uint32_t triangle = texels.triangle[y * size_t(layout.size) + size_t(x)];
        if (triangle == kNoTriangle) continue;
        const glm::dvec3 weights =
            NearestWeights(layout.corners[triangle], glm::dvec2(x, double(y)) + 0.5);
        const Blend blend =
            BlendPhotos(surface.At(triangle, weights), photos, candidates.photos[triangle],
                        surface.ColorAt(triangle, weights));
        for (int c = 0; c < 3; ++c) {
          baked.image.At(x, int(y))[c] =
              uint8_t(std::lround(255 * std::clamp(blend.color[c], 0.0, 1.0)));
        }
        seen_in_row[y] += blend.seen;
        texels_in_row[y] += 1;
      }
    }
  });
  double seen = 0, all = 0;
  for (size_t y = 0; y < seen_in_row.size(); ++y) {
    seen += seen_in_row[y];
    all += texels_in_row[y];
  }
  baked.seen_share = all > 0 ? seen / all : 0;
  return baked;
}

}  // namespace tetrec
