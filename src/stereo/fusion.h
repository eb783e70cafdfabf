// One cloud of points from the depth maps of all views.
#pragma once

#include "run/stereo_depth.h"
#include "stereo/stereo_view.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

namespace tetrec {

struct DensePoint {
  glm::dvec3 position{0.0};                    // [world units]
  glm::dvec3 normal{0.0};                      // unit, towards the views that see it
  std::array<uint8_t, 3> color_srgb{0, 0, 0};  // median over the pixels that show it
  double spacing = 0;                          // to its neighbours, about [world units]
  std::vector<uint32_t> views;  // positions in `views` of those that see it, ascending
};

struct FusionOptions {
  size_t max_points = 12'000;  // about; above 0; the spacing follows from it
  double see_through = 0.03;   // a depth this much (relative) behind a point contradicts it
  // About as many are in memory at once, with some 80 bytes each; above 0.
  size_t pixels_at_once = 4'000'000;
};

struct Fusion {
  std::vector<DensePoint> points;
  uint64_t pixels = 0;        // with a depth
  uint64_t contradicted = 0;  // points dropped because as many views see through them as see them
  double spacing_px = 0;      // distance between points in pixels of the views that see them
};

// Averages the depths' points in cells whose side is proportional to the footprint of a pixel
// there. The points are in no order. `maps` and `views` correspond.
Fusion FuseDepths(std::span<const StereoDepth> maps, std::span<const StereoView> views,
                  const FusionOptions& options);

// x y z, nx ny nz, red green blue, views (how many see the point).
void WriteDensePoints(const std::filesystem::path& path, std::span<const DensePoint> points);

}  // namespace tetrec
