// Visibility of points in photos.
#include "surface/sighting.h"

#include "core/parallel.h"
#include "image/pixels_around.h"
#include "surface/vertex_normals.h"

#include <algorithm>
#include <utility>

namespace tetrec {
namespace {

constexpr double kSteepestCosine = 0.15;  // of the slant at which photos no longer count
// A point that is no more than this many footprints behind the drawn surface, slopes aside, counts
// as being on it.
constexpr double kToleranceFootprints = 3;

// Of the photos that may see a triangle. More add little but time: on lego at 200x200 with 100
// photos, of which 46 show a triangle on average, 20 to 32 give better held-out views than all.
constexpr size_t kMostPhotos = 24;

template <class OfVertex>
glm::dvec3 Interpolated(const glm::uvec3& triangle, const glm::dvec3& weights,
                        const OfVertex& value) {
  return weights.x * value(triangle.x) + weights.y * value(triangle.y) +
         weights.z * value(triangle.z);
}

}  // namespace

SurfacePoints::SurfacePoints(const TriangleMesh& mesh)
    : mesh_(mesh), normals_(SmoothNormals(mesh, 1)) {}

SurfacePoint SurfacePoints::At(uint32_t triangle, const glm::dvec3& weights) const {
  const glm::uvec3& t = mesh_.triangles[triangle];
  const glm::dvec3 normal = Interpolated(t, weights, [&](uint32_t v) { return normals_[v]; });
  const double length = glm::length(normal);
  return {Interpolated(t, weights, [&](uint32_t v) { return glm::dvec3(mesh_.positions[v]); }),
          length > 0 ? normal / length : normal};
}

glm::dvec3 SurfacePoints::ColorAt(uint32_t triangle, const glm::dvec3& weights) const {
  return Interpolated(mesh_.triangles[triangle], weights, [&](uint32_t v) {
    const auto& rgb = mesh_.colors_srgb[v];
    return glm::dvec3(rgb[0], rgb[1], rgb[2]) / 255.0;
  });
}

std::optional<Sighting> See(const SurfacePoint& point, const TexturePhoto& photo) {
  const glm::dvec3 in_cam = photo.cam_from_world * point.position;
  if (!photo.camera.Shows(in_cam)) return std::nullopt;
  const glm::dvec3 normal_in_cam = photo.cam_from_world.rotation * point.normal;
  const double cosine = -glm::dot(normal_in_cam, in_cam) / glm::length(in_cam);
  if (!(cosine > kSteepestCosine)) return std::nullopt;
  const Sighting sighting{photo.camera.ImageFromCam(in_cam), photo.Footprint(in_cam.z),
                          (cosine - kSteepestCosine) / (1 - kSteepestCosine)};
  double farthest = 0;
  for (const auto& [x, y, weight] :
       PixelsAround(photo.camera.width, photo.camera.height, sighting.pixel)) {
    if (weight > 0) farthest = std::max(farthest, double(photo.depth[photo.Index(x, y)]));
  }
  if (in_cam.z > farthest + kToleranceFootprints * sighting.footprint) return std::nullopt;
  return sighting;
}

namespace {

glm::dvec3 CenterOf(const TriangleMesh& mesh, const glm::uvec3& t) {
  return (glm::dvec3(mesh.positions[t.x]) + glm::dvec3(mesh.positions[t.y]) +
          glm::dvec3(mesh.positions[t.z])) /
         3.0;
}

// Pixels with which a photo shows a triangle, up to a factor that is the triangle's; 0 from behind.
double PixelsOf(const TexturePhoto& photo, const SurfacePoint& center) {
  const glm::dvec3 in_cam = photo.cam_from_world * center.position;
  const double cosine =
      -glm::dot(photo.cam_from_world.rotation * center.normal, in_cam) / glm::length(in_cam);
  const double footprint = photo.Footprint(in_cam.z);
  return std::max(cosine, 0.0) / (footprint * footprint);
}

// Keeps the photos with the most pixels of a triangle, in their order.
void KeepBest(const SurfacePoint& center, std::span<const TexturePhoto> photos,
              std::vector<uint32_t>& ids) {
  if (ids.size() <= kMostPhotos) return;
  std::vector<std::pair<double, uint32_t>> best;  // the lowest first
  for (const uint32_t id : ids) best.emplace_back(-PixelsOf(photos[id], center), id);
  std::nth_element(best.begin(), best.begin() + kMostPhotos, best.end());
  ids.clear();
  for (size_t i = 0; i < kMostPhotos; ++i) ids.push_back(best[i].second);
  std::sort(ids.begin(), ids.end());
}

}  // namespace

std::vector<std::vector<uint32_t>> PhotosOfTriangles(const TriangleMesh& mesh,
                                                     std::span<const TexturePhoto> photos) {
  std::vector<std::vector<uint32_t>> result(mesh.triangles.size());
  ParallelFor(mesh.triangles.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t t = begin; t < end; ++t) {
      const glm::uvec3& corners = mesh.triangles[t];
      for (uint32_t i = 0; i < photos.size(); ++i) {
        const std::vector<bool>& shows = photos[i].shows;
        if (shows[corners.x] || shows[corners.y] || shows[corners.z]) result[t].push_back(i);
      }
      // The triangle's own normal: with the mean of its vertices' the choice is worse than none.
      KeepBest({CenterOf(mesh, corners), DoubleAreaNormal(mesh, corners)}, photos, result[t]);
    }
  });
  return result;
}

}  // namespace tetrec
