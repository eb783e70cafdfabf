// Space that photos show to be empty.
#include "optimize/seen_space.h"

#include "core/error.h"
#include "core/parallel.h"

#include <fmt/format.h>

#include <algorithm>

namespace tetrec {
namespace {

namespace fs = std::filesystem;

constexpr int kLeastVotes = 2;
// Other views that must confirm a depth: a wrong one would keep empty what is full, which learning
// cannot mend.
constexpr int kLeastAgreement = 2;
// Share of a depth by which a place must lie in front of it.
constexpr double kMargin = 0.05;
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

}  // namespace

SeenSpace::LeastDepths SeenSpace::LeastDepthsOf(const Scene& scene, const StereoDepth& map) {
  LeastDepths least{scene.views[map.view].cam_from_world, CameraOfBlocks(map.camera), {}};
  least.depth.assign(size_t(least.camera.width) * size_t(least.camera.height), 0.0f);
  for (int y = 0; y < map.camera.height; ++y) {
    for (int x = 0; x < map.camera.width; ++x) {
      const size_t pixel = map.Index(x, y);
      if (map.agreement[pixel] < kLeastAgreement) continue;
      float& depth =
          least.depth[size_t(y / kBlock) * size_t(least.camera.width) + size_t(x / kBlock)];
      if (depth == 0 || map.depth[pixel] < depth) depth = map.depth[pixel];
    }
  }
  return least;
}

SeenSpace::SeenSpace(const Scene& scene, std::span<const StereoDepth> maps) : frames_(scene) {
  for (const StereoDepth& map : maps) maps_.push_back(LeastDepthsOf(scene, map));
}

SeenSpace SeenSpace::Read(const Scene& scene, const fs::path& start_folder) {
  SeenSpace space(scene, {});
  for (const int view : scene.ViewsOf(Split::kTrain)) {
    const fs::path path = start_folder / "depth" / StereoDepthName(uint32_t(view));
    if (!fs::exists(path)) continue;
    const StereoDepth map = ReadStereoDepth(path);
    if (map.view != uint32_t(view)) {
      throw DataError(
          fmt::format("{}: is the depth map of view {}, not {}", path.string(), map.view, view));
    }
    space.maps_.push_back(LeastDepthsOf(scene, map));
  }
  return space;
}

bool SeenSpace::Contains(const glm::dvec3& point) const {
  int votes = 0;
  for (const LeastDepths& map : maps_) {
    const glm::dvec3 in_cam = map.cam_from_world * point;
    if (!map.camera.Shows(in_cam)) continue;
    const glm::dvec2 block = map.camera.ImageFromCam(in_cam);
    const double depth = map.depth[size_t(block.y) * size_t(map.camera.width) + size_t(block.x)];
    if (depth == 0 || in_cam.z > (1 + kMargin) * depth) continue;
    if (in_cam.z > (1 - kMargin) * depth) return false;
    ++votes;
  }
  return votes >= kLeastVotes && !frames_.ManyShow(point);
}

std::vector<uint8_t> SeenSpace::Contains(std::span<const glm::vec3> points) const {
  std::vector<uint8_t> inside(points.size(), 0);
  if (empty()) return inside;
  ParallelFor(points.size(), 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) inside[i] = uint8_t(Contains(glm::dvec3(points[i])));
  });
  return inside;
}

}  // namespace tetrec
