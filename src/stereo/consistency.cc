// Depths that other views confirm.
#include "stereo/consistency.h"

#include "core/error.h"
#include "core/parallel.h"

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

// Of the four pixels around a point of the camera frame, the depth that is closest to the point's,
// or 0 if none has a depth.
double ClosestDepth(const StereoDepth& map, const glm::dvec3& in_cam) {
  const glm::dvec2 pixel = map.camera.ImageFromCam(in_cam) - 0.5;
  const int x0 = int(std::floor(pixel.x)), y0 = int(std::floor(pixel.y));
  double closest = 0;
  for (int y = std::max(0, y0); y <= std::min(map.camera.height - 1, y0 + 1); ++y) {
    for (int x = std::max(0, x0); x <= std::min(map.camera.width - 1, x0 + 1); ++x) {
      const double depth = map.depth[map.Index(x, y)];
      if (depth > 0 && std::abs(depth - in_cam.z) < std::abs(closest - in_cam.z)) closest = depth;
    }
  }
  return closest;
}

struct Other {
  const StereoDepth* map;
  Rigid3 other_from_cam;
};

StereoDepth CountOne(const StereoDepth& map, std::span<const Other> others, double tolerance) {
  StereoDepth counted = map;
  for (int y = 0; y < map.camera.height; ++y) {
    for (int x = 0; x < map.camera.width; ++x) {
      const size_t i = map.Index(x, y);
      counted.agreement[i] = 0;
      if (!(map.depth[i] > 0)) continue;
      const glm::dvec3 in_cam = double(map.depth[i]) * map.camera.CamFromImage({x + 0.5, y + 0.5});
      // The ratios of the inverse depths that the others see to those that they should see.
      double ratios = 1;
      int agreeing = 0;
      for (const Other& other : others) {
        const glm::dvec3 in_other = other.other_from_cam * in_cam;
        if (!other.map->camera.Shows(in_other)) continue;
        const double seen = ClosestDepth(*other.map, in_other);
        if (!(seen > 0) || std::abs(in_other.z / seen - 1) > tolerance) continue;
        ratios += in_other.z / seen;
        ++agreeing;
      }
      counted.depth[i] = float(double(map.depth[i]) * (agreeing + 1) / ratios);
      counted.agreement[i] = uint8_t(std::min(agreeing, 255));
    }
  }
  return counted;
}

// The pixels of the patch that contains `start`, which is confirmed; marks them.
std::vector<size_t> PatchAround(const StereoDepth& map, size_t start, double tolerance,
                                std::vector<uint8_t>& is_done) {
  const int width = map.camera.width, height = map.camera.height;
  std::vector<size_t> patch{start};
  is_done[start] = 1;
  for (size_t next = 0; next < patch.size(); ++next) {
    const double depth = map.depth[patch[next]];
    const int x = int(patch[next] % size_t(width)), y = int(patch[next] / size_t(width));
    for (int ny = std::max(0, y - 1); ny <= std::min(height - 1, y + 1); ++ny) {
      for (int nx = std::max(0, x - 1); nx <= std::min(width - 1, x + 1); ++nx) {
        const size_t i = map.Index(nx, ny);
        const double other = map.depth[i];
        const bool is_near = std::abs(other - depth) <= tolerance * std::max(other, depth);
        if (is_done[i] != 0 || map.agreement[i] == 0 || !is_near) continue;
        is_done[i] = 1;
        patch.push_back(i);
      }
    }
  }
  return patch;
}

uint64_t EvidenceOf(const StereoDepth& map, std::span<const size_t> patch) {
  uint64_t evidence = 0;
  for (const size_t i : patch) evidence += uint64_t{map.agreement[i]} * map.agreement[i];
  return evidence;
}

void Drop(StereoDepth& map, size_t pixel) {
  map.depth[pixel] = 0;
  map.agreement[pixel] = 0;
}

}  // namespace

std::vector<StereoDepth> CountAgreement(std::span<const StereoDepth> maps,
                                        std::span<const StereoView> views,
                                        std::span<const std::vector<uint32_t>> others,
                                        double tolerance) {
  TETREC_CHECK(maps.size() == views.size() && maps.size() == others.size(), "a map for each view");
  std::vector<StereoDepth> counted(maps.size());
  ParallelFor(maps.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Rigid3 world_from_cam = views[i].cam_from_world.Inverse();
      std::vector<Other> with;
      for (const uint32_t j : others[i]) {
        with.push_back({&maps[j], views[j].cam_from_world * world_from_cam});
      }
      counted[i] = CountOne(maps[i], with, tolerance);
    }
  });
  return counted;
}

uint64_t CountDepths(const StereoDepth& map) {
  return uint64_t(
      std::count_if(map.depth.begin(), map.depth.end(), [](float depth) { return depth > 0; }));
}

double ShareConfirmedByTwo(std::span<const StereoDepth> maps) {
  uint64_t depths = 0, by_two = 0;
  for (const StereoDepth& map : maps) {
    depths += CountDepths(map);
    by_two += uint64_t(std::ranges::count_if(map.agreement, [](uint8_t n) { return n >= 2; }));
  }
  return depths > 0 ? double(by_two) / double(depths) : 1.0;
}

int ViewsToConfirm(std::span<const StereoDepth> maps) {
  return ShareConfirmedByTwo(maps) >= 0.5 ? 2 : 1;
}

uint64_t KeepConfirmed(StereoDepth& map, int least_views, int least_evidence, double tolerance) {
  for (size_t i = 0; i < map.depth.size(); ++i) {
    if (map.agreement[i] < least_views) Drop(map, i);
  }
  uint64_t kept = 0;
  std::vector<uint8_t> is_done(map.depth.size(), 0);
  for (size_t i = 0; i < map.depth.size(); ++i) {
    if (is_done[i] != 0 || map.agreement[i] == 0) continue;
    const std::vector<size_t> patch = PatchAround(map, i, tolerance, is_done);
    if (EvidenceOf(map, patch) >= uint64_t(least_evidence)) {
      kept += patch.size();
    } else {
      for (const size_t pixel : patch) Drop(map, pixel);
    }
  }
  return kept;
}

}  // namespace tetrec
