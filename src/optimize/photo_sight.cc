// What the training photos see of a place.
#include "optimize/photo_sight.h"

#include "core/parallel.h"

#include <algorithm>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

constexpr int kFewPhotos = 12;
constexpr int kLeastMaps = 2;
// A place within this share of a depth is near it, and may be what the map shows.
constexpr double kNear = 0.05;
// A place is hidden if it lies behind a depth by more than this share of it. What hangs from the
// edge of a table is only slightly behind that edge.
constexpr double kHiddenBehind = 0.02;
// A map shows a surface at a place from this share of the depth before it to this share behind it:
// a shell that starts at the surface, within the errors of depths, and is thick enough for
// vertices.
constexpr double kSurfaceBefore = 0.004, kSurfaceBehind = 0.015;
constexpr size_t kSmallCollection = 20;
constexpr int kLeastMapsOfSurface = 3, kLeastMapsOfSmallCollection = 2;
constexpr int kMapsAtPerMapThrough = 5;
// Pixels of a map per block, along each side: for what is near, few compared with what a vertex
// covers; for what hides a place, as few as memory allows, because edges are sharp.
constexpr int kBlockOfLeast = 4, kBlockOfLargest = 2;

Camera CameraOfBlocks(const Camera& camera, int side) {
  return {.width = (camera.width + side - 1) / side,
          .height = (camera.height + side - 1) / side,
          .fx = camera.fx / side,
          .fy = camera.fy / side,
          .cx = camera.cx / side,
          .cy = camera.cy / side};
}

// The one that `choose` selects of the confirmed depths in each block of side x side pixels.
template <typename Choose>
std::vector<float> DepthOfBlocks(const StereoDepth& map, int side, Choose choose) {
  const Camera blocks = CameraOfBlocks(map.camera, side);
  std::vector<float> depths(size_t(blocks.width) * size_t(blocks.height), 0.0f);
  for (int y = 0; y < map.camera.height; ++y) {
    for (int x = 0; x < map.camera.width; ++x) {
      const size_t pixel = map.Index(x, y);
      if (map.agreement[pixel] < kLeastAgreement) continue;
      float& depth = depths[size_t(y / side) * size_t(blocks.width) + size_t(x / side)];
      depth = depth == 0 ? map.depth[pixel] : choose(depth, map.depth[pixel]);
    }
  }
  return depths;
}

}  // namespace

PhotoSight::PhotoSight(const Scene& scene, std::span<const StereoDepth> maps) {
  for (const int v : scene.ViewsOf(Split::kTrain)) {
    const View& view = scene.views[size_t(v)];
    photos_.push_back(
        {uint32_t(v), view.cam_from_world, scene.cameras[size_t(view.camera)], {}, {}});
  }
  for (const StereoDepth& map : maps) {
    const auto photo = std::ranges::find(photos_, map.view, &Photo::view);
    if (photo == photos_.end()) continue;
    photo->Summarize(map);
    has_maps_ = true;
  }
}

PhotoSight PhotoSight::Read(const Scene& scene, const fs::path& start_folder) {
  PhotoSight sight(scene);
  for (Photo& photo : sight.photos_) {
    const std::optional<StereoDepth> map = FindStereoDepth(start_folder, photo.view);
    if (!map) continue;
    photo.Summarize(*map);
    sight.has_maps_ = true;
  }
  return sight;
}

void PhotoSight::Photo::Summarize(const StereoDepth& map) {
  least = {CameraOfBlocks(map.camera, kBlockOfLeast),
           DepthOfBlocks(map, kBlockOfLeast, [](float a, float b) { return std::min(a, b); })};
  largest = {CameraOfBlocks(map.camera, kBlockOfLargest),
             DepthOfBlocks(map, kBlockOfLargest, [](float a, float b) { return std::max(a, b); })};
}

float PhotoSight::Blocks::DepthAt(const glm::dvec3& in_cam) const {
  if (depth.empty() || !camera.Shows(in_cam)) return 0;
  const glm::dvec2 block = camera.ImageFromCam(in_cam);
  return depth[size_t(block.y) * size_t(camera.width) + size_t(block.x)];
}

bool PhotoSight::Photo::Sees(const glm::dvec3& in_cam) const {
  if (!camera.Shows(in_cam)) return false;
  const double depth = largest.DepthAt(in_cam);
  return depth == 0 || in_cam.z <= (1 + kHiddenBehind) * depth;
}

PlaceSight PhotoSight::Of(const glm::dvec3& place) const {
  int photos = 0, maps_behind = 0, maps_at = 0, maps_through = 0;
  bool is_near = false;
  for (const Photo& photo : photos_) {
    const glm::dvec3 in_cam = photo.cam_from_world * place;
    if (!photo.camera.Shows(in_cam)) continue;
    const double largest = photo.largest.DepthAt(in_cam), least = photo.least.DepthAt(in_cam);
    if (photo.Sees(in_cam) && ++photos > kFewPhotos && !has_maps_) return {.is_of_many = true};
    if (largest > 0 && in_cam.z <= (1 + kSurfaceBehind) * largest) {
      ++(in_cam.z < (1 - kSurfaceBefore) * largest ? maps_through : maps_at);
    }
    if (least == 0 || in_cam.z > (1 + kNear) * least) continue;
    if (in_cam.z > (1 - kNear) * least) {
      is_near = true;
    } else {
      ++maps_behind;
    }
  }
  const bool is_of_many = photos > kFewPhotos;
  const int least_maps = IsOfSmallCollection() ? kLeastMapsOfSmallCollection : kLeastMapsOfSurface;
  return {.is_of_many = is_of_many,
          .is_empty = !is_of_many && maps_behind >= kLeastMaps && !is_near,
          .is_surface = maps_at >= least_maps && maps_at >= kMapsAtPerMapThrough * maps_through};
}

bool PhotoSight::IsOfSmallCollection() const { return photos_.size() <= kSmallCollection; }

std::vector<glm::dvec3> PhotoSight::CentersThatSee(const glm::dvec3& place) const {
  std::vector<glm::dvec3> centers;
  for (const Photo& photo : photos_) {
    if (photo.Sees(photo.cam_from_world * place)) {
      centers.push_back(photo.cam_from_world.Inverse().translation);
    }
  }
  return centers;
}

std::vector<glm::dvec3> PhotoSight::Centers() const {
  std::vector<glm::dvec3> centers;
  for (const Photo& photo : photos_) {
    centers.push_back(photo.cam_from_world.Inverse().translation);
  }
  return centers;
}

std::vector<PlaceSight> PhotoSight::Of(std::span<const glm::vec3> places) const {
  std::vector<PlaceSight> sights(places.size());
  ParallelFor(places.size(), 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) sights[i] = Of(glm::dvec3(places[i]));
  });
  return sights;
}

}  // namespace tetrec
