// The photos that a texture is made from.
#include "surface/texture_photos.h"

#include "core/error.h"
#include "core/parallel.h"
#include "image/pixels_around.h"
#include "mesh/seen_triangles.h"
#include "run/photo_exposures.h"
#include "scene/scene.h"
#include "surface/trained_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace tetrec {
namespace {
namespace fs = std::filesystem;

// A surface that is seen at a slant of 80 degrees has depths that differ by 6 footprints between
// pixels; larger differences are jumps from one surface to another.
constexpr double kJumpFootprints = 8;
constexpr double kToleranceFootprints = 3;  // of a point behind the drawn surface, slopes aside

bool Jumps(const TexturePhoto& photo, size_t a, size_t b) {
  const double near = std::min(photo.depth[a], photo.depth[b]);
  const double far = std::max(photo.depth[a], photo.depth[b]);
  return std::isfinite(near) && !(far - near < kJumpFootprints * photo.Footprint(near));
}

// 0 for pixels that are not trusted, kFullTrust for the others.
std::vector<int> Untrusted(const TexturePhoto& photo) {
  const int width = photo.camera.width, height = photo.camera.height;
  std::vector<int> distance(photo.depth.size(), kFullTrust);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const size_t i = photo.Index(x, y);
      if (x == 0 || y == 0 || x == width - 1 || y == height - 1 || !photo.Counts(x, y)) {
        distance[i] = 0;
        continue;
      }
      for (const size_t next : {i + 1, i + size_t(width)}) {
        if (Jumps(photo, i, next)) distance[i] = distance[next] = 0;
      }
    }
  }
  return distance;
}

// Steps to the nearest 0, along rows and columns and diagonally, in two passes.
void SpreadDistances(int width, int height, std::vector<int>& distance) {
  const auto at = [&](int x, int y) -> int& {
    return distance[size_t(y) * size_t(width) + size_t(x)];
  };
  for (int y = 1; y < height; ++y) {
    for (int x = 1; x < width - 1; ++x) {
      const int before = std::min({at(x - 1, y), at(x - 1, y - 1), at(x, y - 1), at(x + 1, y - 1)});
      at(x, y) = std::min(at(x, y), before + 1);
    }
  }
  for (int y = height - 2; y >= 0; --y) {
    for (int x = width - 2; x > 0; --x) {
      const int behind = std::min({at(x + 1, y), at(x - 1, y + 1), at(x, y + 1), at(x + 1, y + 1)});
      at(x, y) = std::min(at(x, y), behind + 1);
    }
  }
}

// Vertices that are seen, and those of triangles that pixels show: a large triangle may be seen
// between its corners, and triangles far smaller than a pixel lie between the rays.
std::vector<bool> SeenVertices(const SeenTriangles& seen, const TriangleMesh& mesh,
                               const TexturePhoto& photo) {
  std::vector<bool> vertices;
  for (const glm::vec3& position : mesh.positions) {
    vertices.push_back(photo.ShowsPoint(photo.cam_from_world * glm::dvec3(position)));
  }
  for (const uint32_t triangle : seen.triangle) {
    if (triangle >= mesh.triangles.size()) continue;  // none, or one that hides the surface
    for (int k = 0; k < 3; ++k) vertices[mesh.triangles[triangle][k]] = true;
  }
  return vertices;
}

// `all` is the mesh, and behind its vertices and triangles those of what hides it.
void FindTrust(const TriangleMesh& mesh, const TriangleMesh& all, TexturePhoto& photo) {
  SeenTriangles seen = FindSeenTriangles(all, photo.camera, photo.cam_from_world);
  photo.depth = std::move(seen.depth);
  photo.hidden.clear();
  if (all.triangles.size() > mesh.triangles.size()) {
    for (const uint32_t triangle : seen.triangle) {
      photo.hidden.push_back(triangle != kNoTriangle && triangle >= mesh.triangles.size());
    }
  }
  photo.shows = SeenVertices(seen, mesh, photo);
  std::vector<int> distance = Untrusted(photo);
  SpreadDistances(photo.camera.width, photo.camera.height, distance);
  photo.trust.clear();
  for (const int steps : distance) photo.trust.push_back(uint8_t(steps));
}

std::map<std::string, PhotoExposure> ExposuresByName(const fs::path& field_folder) {
  std::map<std::string, PhotoExposure> by_name;
  const fs::path file = field_folder / kPhotoExposuresFile;
  if (!fs::exists(file)) return by_name;
  for (const PhotoExposure& exposure : ReadPhotoExposures(file)) {
    by_name.emplace(exposure.name, exposure);
  }
  return by_name;
}

}  // namespace

bool TexturePhoto::ShowsPoint(const glm::dvec3& in_cam) const {
  if (!camera.Shows(in_cam)) return false;
  double farthest = 0;
  for (const auto& [x, y, weight] :
       PixelsAround(camera.width, camera.height, camera.ImageFromCam(in_cam))) {
    if (weight > 0) farthest = std::max(farthest, double(depth[Index(x, y)]));
  }
  return in_cam.z <= farthest + kToleranceFootprints * Footprint(in_cam.z);
}

bool TexturePhoto::Counts(int x, int y) const {
  if (Hides(x, y)) return false;
  if (image.channels == 3) return true;
  return image.At(x, y)[3] >= (alpha_is_opacity ? 255 : kSeenAlpha);
}

void FindTrust(const TriangleMesh& mesh_in_world, std::span<TexturePhoto> photos,
               const TriangleMesh& hiding_in_world) {
  if (hiding_in_world.triangles.empty()) {
    ParallelForEach(photos.size(), "", kAfterASurfaceStop,
                    [&](size_t i) { FindTrust(mesh_in_world, mesh_in_world, photos[i]); });
    return;
  }
  const TriangleMesh both = Joined(mesh_in_world, hiding_in_world);
  ParallelForEach(photos.size(), "", kAfterASurfaceStop,
                  [&](size_t i) { FindTrust(mesh_in_world, both, photos[i]); });
}

void FindTrust(const TriangleMesh& mesh_in_world, TexturePhoto& photo) {
  FindTrust(mesh_in_world, mesh_in_world, photo);
}

std::vector<TexturePhoto> ReadTexturePhotos(const fs::path& scene_folder,
                                            const fs::path& field_folder) {
  const Scene scene = ReadScene(scene_folder);
  const std::map<std::string, PhotoExposure> exposures = ExposuresByName(field_folder);
  const std::vector<TrainedView> views = TrainedViews(scene, field_folder);
  std::vector<TexturePhoto> photos(views.size());
  ParallelForEach(views.size(), "", kAfterASurfaceStop, [&](size_t i) {
    const TrainedView& view = views[i];
    TexturePhoto& photo = photos[i];
    photo.camera = view.camera;
    photo.cam_from_world = view.cam_from_world;
    photo.alpha_is_opacity = scene.has_alpha;
    if (const auto found = exposures.find(view.name); found != exposures.end()) {
      photo.gain = found->second.gain;
      photo.offset = found->second.offset;
    }
    photo.image = ReadImage(scene_folder / view.image);
    if (photo.image.width != photo.camera.width || photo.image.height != photo.camera.height) {
      throw DataError(
          fmt::format("{}: has {} x {} pixels, its camera {} x {}; import the photos again",
                      (scene_folder / view.image).string(), photo.image.width, photo.image.height,
                      photo.camera.width, photo.camera.height));
    }
    if (scene.has_alpha && photo.image.channels != 4) {
      throw DataError(fmt::format("{}: has no alpha, unlike the scene; import the photos again",
                                  (scene_folder / view.image).string()));
    }
  });
  return photos;
}

}  // namespace tetrec
