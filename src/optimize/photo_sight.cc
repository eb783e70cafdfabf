// What the training photos see of a place.
#include "optimize/photo_sight.h"

#include "core/error.h"
#include "core/parallel.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

constexpr int kFewPhotos = 12;
constexpr int kLeastMaps = 2;
// Other views that must confirm a depth: a wrong one would keep empty what is full, which learning
// cannot mend.
constexpr int kLeastAgreement = 2;
// Shares of a depth by which a place must lie in front of it to be empty, or behind it to be
// hidden. What hangs behind the edge of a table is hidden by a little.
constexpr double kMarginInFront = 0.05, kMarginBehind = 0.02;
// Pixels of a map per block, along each side: small against what a vertex shows.
constexpr int kBlock = 4;

Camera CameraOfBlocks(const Camera& camera) {
  return {.width = (camera.width + kBlock - 1) / kBlock,
          .height = (camera.height + kBlock - 1) / kBlock,
          .fx = camera.fx / kBlock,
          .fy = camera.fy / kBlock,
          .cx = camera.cx / kBlock,
          .cy = camera.cy / kBlock};
}

// For each block of the map the least depth that is confirmed, or 0.
std::vector<float> LeastDepths(const StereoDepth& map, const Camera& blocks) {
  std::vector<float> least(size_t(blocks.width) * size_t(blocks.height), 0.0f);
  for (int y = 0; y < map.camera.height; ++y) {
    for (int x = 0; x < map.camera.width; ++x) {
      const size_t pixel = map.Index(x, y);
      if (map.agreement[pixel] < kLeastAgreement) continue;
      float& depth = least[size_t(y / kBlock) * size_t(blocks.width) + size_t(x / kBlock)];
      if (depth == 0 || map.depth[pixel] < depth) depth = map.depth[pixel];
    }
  }
  return least;
}

}  // namespace

PhotoSight::PhotoSight(const Scene& scene, std::span<const StereoDepth> maps) {
  for (const int v : scene.ViewsOf(Split::kTrain)) {
    const View& view = scene.views[size_t(v)];
    Photo photo{view.cam_from_world, scene.cameras[size_t(view.camera)], {}};
    const auto map = std::ranges::find(maps, uint32_t(v), &StereoDepth::view);
    if (map != maps.end()) {
      photo.camera = CameraOfBlocks(map->camera);
      photo.least_depth = LeastDepths(*map, photo.camera);
    }
    photos_.push_back(std::move(photo));
  }
}

PhotoSight PhotoSight::Read(const Scene& scene, const fs::path& start_folder) {
  std::vector<StereoDepth> maps;
  for (const int view : scene.ViewsOf(Split::kTrain)) {
    const fs::path path = start_folder / "depth" / StereoDepthName(uint32_t(view));
    if (!fs::exists(path)) continue;
    maps.push_back(ReadStereoDepth(path));
    if (maps.back().view != uint32_t(view)) {
      throw DataError(fmt::format("{}: is the depth map of view {}, not {}", path.string(),
                                  maps.back().view, view));
    }
  }
  return PhotoSight(scene, maps);
}

float PhotoSight::Photo::LeastDepthAt(const glm::dvec3& in_cam) const {
  if (least_depth.empty()) return 0;
  const glm::dvec2 block = camera.ImageFromCam(in_cam);
  return least_depth[size_t(block.y) * size_t(camera.width) + size_t(block.x)];
}

PlaceSight PhotoSight::Of(const glm::dvec3& place) const {
  int photos = 0, maps_behind = 0;
  bool is_near = false;
  for (const Photo& photo : photos_) {
    const glm::dvec3 in_cam = photo.cam_from_world * place;
    if (!photo.camera.Shows(in_cam)) continue;
    const double depth = photo.LeastDepthAt(in_cam);
    if (depth > 0 && in_cam.z > (1 + kMarginBehind) * depth) continue;
    if (++photos > kFewPhotos) return PlaceSight::kMany;
    if (depth == 0) continue;
    if (in_cam.z > (1 - kMarginInFront) * depth) {
      is_near = true;
    } else {
      ++maps_behind;
    }
  }
  return maps_behind >= kLeastMaps && !is_near ? PlaceSight::kEmpty : PlaceSight::kFew;
}

std::vector<PlaceSight> PhotoSight::Of(std::span<const glm::vec3> places) const {
  std::vector<PlaceSight> sights(places.size());
  ParallelFor(places.size(), 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) sights[i] = Of(glm::dvec3(places[i]));
  });
  return sights;
}

}  // namespace tetrec
