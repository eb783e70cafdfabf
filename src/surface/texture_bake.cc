// Points on the surface, the photos that see them, and their mean.
#include "surface/texture_bake.h"

#include "core/parallel.h"
#include "core/quantile.h"
#include "surface/continue_colors.h"
#include "surface/texels.h"
#include "surface/vertex_normals.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetrec {
namespace {

constexpr size_t kBlended = 3;            // photos that a texel is the mean of
constexpr double kSteepestCosine = 0.15;  // of the slant at which photos no longer count
// Of the depth behind the surface at which a point still counts as on it, besides slopes.
constexpr double kToleranceFootprints = 3;
// A texel whose best photo counts less than this is partly of the vertices' colour.
constexpr double kDecidingQuality = 0.1;

// A point of the surface in world coordinates.
struct SurfacePoint {
  glm::dvec3 position, normal;
};

struct Sighting {
  double weight = 0;   // squared pixels per unit of area, times quality
  double quality = 0;  // 1: from the front and far from outlines, 0: not seen
  double footprint = 0;
  glm::dvec2 pixel{0.0};
  uint32_t photo = 0;
};

// Of the four pixels around a position, with the weights of bilinear interpolation.
struct Around {
  int x, y;
  double fx, fy;

  explicit Around(const glm::dvec2& pixel)
      : x(int(std::floor(pixel.x - 0.5))),
        y(int(std::floor(pixel.y - 0.5))),
        fx(pixel.x - 0.5 - x),
        fy(pixel.y - 0.5 - y) {}
  template <class Value>
  auto Mean(const Value& value) const {
    return (1 - fy) * ((1 - fx) * value(x, y) + fx * value(x + 1, y)) +
           fy * ((1 - fx) * value(x, y + 1) + fx * value(x + 1, y + 1));
  }
};

Sighting See(const SurfacePoint& point, const TexturePhoto& photo, uint32_t id) {
  const glm::dvec3 in_cam = photo.cam_from_world * point.position;
  if (!photo.camera.Shows(in_cam)) return {};
  const glm::dvec3 normal_in_cam = photo.cam_from_world.rotation * point.normal;
  const double cosine = -glm::dot(normal_in_cam, in_cam) / glm::length(in_cam);
  if (!(cosine > kSteepestCosine)) return {};
  const glm::dvec2 pixel = photo.camera.ImageFromCam(in_cam);
  const Around around(pixel);
  if (around.x < 0 || around.y < 0 || around.x + 1 >= photo.camera.width ||
      around.y + 1 >= photo.camera.height) {
    return {};
  }
  double farthest = 0;
  for (const auto& [x, y] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
    farthest = std::max(farthest, double(photo.depth[photo.Index(around.x + x, around.y + y)]));
  }
  const double footprint = photo.Footprint(in_cam.z);
  if (in_cam.z > farthest + kToleranceFootprints * footprint) return {};
  const double trust = around.Mean([&](int x, int y) {
    return double(photo.trust[photo.Index(x, y)]);
  }) / kFullTrust;
  const double facing = (cosine - kSteepestCosine) / (1 - kSteepestCosine);
  const double quality = trust * facing * facing;
  return {quality / (footprint * footprint), quality, footprint, pixel, id};
}

glm::dvec3 ColorAt(const TexturePhoto& photo, const glm::dvec2& pixel) {
  const glm::dvec3 shown = Around(pixel).Mean([&](int x, int y) {
    const uint8_t* rgb = photo.image.At(x, y);
    return glm::dvec3(rgb[0], rgb[1], rgb[2]) / 255.0;
  });
  return (shown - photo.offset) / photo.gain;
}

// The mean of the best photos, over the color that is taken where none sees the point well.
struct Blend {
  glm::dvec3 color{0.0};
  double seen = 0;  // share that photos decide
};

Blend BlendPhotos(const SurfacePoint& point, std::span<const TexturePhoto> photos,
                  std::span<const uint32_t> candidates, const glm::dvec3& unseen) {
  std::array<Sighting, kBlended + 1> best{};  // from the best one on
  for (const uint32_t id : candidates) {
    Sighting sighting = See(point, photos[id], id);
    for (Sighting& other : best) {
      if (sighting.weight > other.weight) std::swap(sighting, other);
    }
  }
  glm::dvec3 sum(0.0);
  double weights = 0;
  for (size_t i = 0; i < kBlended; ++i) {
    const double weight = best[i].weight - best[kBlended].weight;
    if (!(weight > 0)) break;
    sum += weight * ColorAt(photos[best[i].photo], best[i].pixel);
    weights += weight;
  }
  if (!(weights > 0)) {
    // Photos that are worth the same, or none.
    if (!(best[0].weight > 0)) return {unseen, 0};
    sum = ColorAt(photos[best[0].photo], best[0].pixel);
    weights = 1;
  }
  const double seen = std::min(1.0, best[0].quality / kDecidingQuality);
  return {glm::mix(unseen, sum / weights, seen), seen};
}

glm::dvec3 VertexColor(const TriangleMesh& mesh, uint32_t vertex) {
  const auto& rgb = mesh.colors_srgb[vertex];
  return glm::dvec3(rgb[0], rgb[1], rgb[2]) / 255.0;
}

template <class OfVertex>
glm::dvec3 Interpolated(const glm::uvec3& triangle, const glm::dvec3& weights,
                        const OfVertex& value) {
  return weights.x * value(triangle.x) + weights.y * value(triangle.y) +
         weights.z * value(triangle.z);
}

class Surface {
 public:
  explicit Surface(const TriangleMesh& mesh) : mesh_(mesh), normals_(SmoothNormals(mesh, 1)) {}

  SurfacePoint At(uint32_t triangle, const glm::dvec3& weights) const {
    const glm::uvec3& t = mesh_.triangles[triangle];
    const glm::dvec3 normal = Interpolated(t, weights, [&](uint32_t v) { return normals_[v]; });
    const double length = glm::length(normal);
    return {Interpolated(t, weights, [&](uint32_t v) { return glm::dvec3(mesh_.positions[v]); }),
            length > 0 ? normal / length : normal};
  }
  glm::dvec3 ColorAt(uint32_t triangle, const glm::dvec3& weights) const {
    return Interpolated(mesh_.triangles[triangle], weights,
                        [&](uint32_t v) { return VertexColor(mesh_, v); });
  }

 private:
  const TriangleMesh& mesh_;
  std::vector<glm::dvec3> normals_;
};

}  // namespace

std::vector<std::vector<uint32_t>> PhotosOfTriangles(const TriangleMesh& mesh,
                                                     std::span<const TexturePhoto> photos) {
  std::vector<std::vector<uint32_t>> result(mesh.triangles.size());
  const Surface surface(mesh);
  ParallelFor(mesh.triangles.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      for (uint32_t i = 0; i < photos.size(); ++i) {
        const Rigid3& cam_from_world = photos[i].cam_from_world;
        bool may_see = false;
        for (int k = 0; k < 3; ++k) {
          glm::dvec3 corner(0.0);
          corner[k] = 1;
          const SurfacePoint point = surface.At(uint32_t(t), corner);
          const glm::dvec3 in_cam = cam_from_world * point.position;
          may_see = may_see ||
                    (in_cam.z > 0 && glm::dot(cam_from_world.rotation * point.normal, in_cam) < 0);
        }
        if (may_see) result[t].push_back(i);
      }
    }
  });
  return result;
}

double MedianFootprint(const TriangleMesh& mesh, std::span<const TexturePhoto> photos) {
  const Surface surface(mesh);
  const std::vector<std::vector<uint32_t>> candidates = PhotosOfTriangles(mesh, photos);
  std::vector<std::pair<double, double>> footprints;  // with areas
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const SurfacePoint center = surface.At(uint32_t(t), glm::dvec3(1.0 / 3));
    Sighting best;
    for (const uint32_t id : candidates[t]) {
      const Sighting sighting = See(center, photos[id], id);
      if (sighting.weight > best.weight) best = sighting;
    }
    if (best.weight > 0) {
      footprints.emplace_back(best.footprint,
                              glm::length(DoubleAreaNormal(mesh, mesh.triangles[t])));
    }
  }
  return footprints.empty() ? 0 : WeightedQuantile(std::move(footprints), 0.5);
}

BakedTexture BakeTexture(const TriangleMesh& mesh, const TextureLayout& layout,
                         std::span<const TexturePhoto> photos) {
  const Texels texels = FindTexels(layout);
  const Surface surface(mesh);
  const std::vector<std::vector<uint32_t>> candidates = PhotosOfTriangles(mesh, photos);
  BakedTexture baked{MakeImage(layout.size, layout.size, 3), 0};
  std::vector<double> seen_in_row(size_t(layout.size), 0), texels_in_row = seen_in_row;
  ParallelFor(size_t(layout.size), 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (int x = 0; x < layout.size; ++x) {
        const uint32_t triangle = texels.triangle[y * size_t(layout.size) + size_t(x)];
        if (triangle == kNoTriangle) continue;
        const glm::dvec3 weights =
            NearestWeights(layout.corners[triangle], glm::dvec2(x, double(y)) + 0.5);
        const Blend blend = BlendPhotos(surface.At(triangle, weights), photos, candidates[triangle],
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
  ContinueColors(baked.image, [&](size_t i) { return texels.triangle[i] != kNoTriangle; });
  return baked;
}

}  // namespace tetrec
