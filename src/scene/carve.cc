// Space carving with integral images.
#include "scene/carve.h"

#include "core/error.h"
#include "core/log.h"
#include "core/parallel.h"
#include "image/image.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

namespace tetrec {
namespace {

// A mask prepared for the query whether any pixel of a rectangle is not transparent.
struct MaskLookup {
  Camera camera;
  Rigid3 cam_from_world;
  double slant = 1;              // largest 1 / cos of the angle between a pixel's ray and the axis
  std::vector<uint32_t> counts;  // integral image, (height + 1) x (width + 1)
};

MaskLookup MakeLookup(const AlphaMask& mask) {
  const Camera& camera = mask.camera;
  MaskLookup lookup{camera, mask.cam_from_world, 1, {}};
  for (const double x : {0, camera.width}) {
    for (const double y : {0, camera.height}) {
      lookup.slant = std::max(lookup.slant, glm::length(camera.CamFromImage({x, y})));
    }
  }
  const size_t stride = size_t(camera.width) + 1;
  lookup.counts.assign(stride * (size_t(camera.height) + 1), 0);
  for (size_t y = 0; y < size_t(camera.height); ++y) {
    uint32_t row = 0;
    for (size_t x = 0; x < size_t(camera.width); ++x) {
      row += mask.alpha[y * size_t(camera.width) + x] > 0 ? 1 : 0;
      lookup.counts[(y + 1) * stride + x + 1] = lookup.counts[y * stride + x + 1] + row;
    }
  }
  return lookup;
}

enum class Sight { kNotWhole, kOccupied, kTransparent };

// What one view shows of a ball.
Sight Look(const MaskLookup& view, const glm::dvec3& center_in_world, double radius) {
  const glm::dvec3 center = view.cam_from_world * center_in_world;
  const double nearest_z = center.z - radius;
  if (nearest_z <= radius)
    return Sight::kNotWhole;  // behind, around or just in front of the camera
  // For |d| <= r: |(x + dx) / (z + dz) - x / z| = |dx - dz x / z| / (z + dz)
  //                                            <= r sqrt(1 + (x / z)^2) / (z - r)
  const Camera& camera = view.camera;
  const glm::dvec2 pixel = camera.ImageFromCam(center);
  const double spread = radius * view.slant / nearest_z;
  const double x0 = std::floor(pixel.x - camera.fx * spread);
  const double x1 = std::floor(pixel.x + camera.fx * spread) + 1;
  const double y0 = std::floor(pixel.y - camera.fy * spread);
  const double y1 = std::floor(pixel.y + camera.fy * spread) + 1;
  if (x0 < 0 || y0 < 0 || x1 > camera.width || y1 > camera.height) return Sight::kNotWhole;
  const size_t stride = size_t(camera.width) + 1;
  const uint32_t* top = &view.counts[size_t(y0) * stride];
  const uint32_t* bottom = &view.counts[size_t(y1) * stride];
  const uint32_t seen = bottom[size_t(x1)] - bottom[size_t(x0)] - top[size_t(x1)] + top[size_t(x0)];
  return seen == 0 ? Sight::kTransparent : Sight::kOccupied;
}

bool IsInside(std::span<const MaskLookup> views, const glm::dvec3& center, double radius,
              int min_views) {
  int seen = 0;
  for (const MaskLookup& view : views) {
    const Sight sight = Look(view, center, radius);
    if (sight == Sight::kTransparent) return false;
    if (sight == Sight::kOccupied) ++seen;
  }
  return seen >= min_views;
}

std::vector<MaskLookup> MakeLookups(std::span<const AlphaMask> masks) {
  std::vector<MaskLookup> views(masks.size());
  ParallelFor(masks.size(), 4, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) views[i] = MakeLookup(masks[i]);
  });
  return views;
}

OccupancyGrid Carve(std::span<const MaskLookup> views, const Bounds3& bounds,
                    const glm::ivec3& size, int min_views) {
  OccupancyGrid grid{bounds, size, {}};
  grid.inside.resize(size_t(size.x) * size_t(size.y) * size_t(size.z));
  const double radius = 0.5 * glm::length(grid.CellSize());
  const size_t row_count = size_t(size.y) * size_t(size.z);
  ParallelFor(row_count, 64, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row) {
      const int y = int(row % size_t(size.y)), z = int(row / size_t(size.y));
      for (int x = 0; x < size.x; ++x) {
        const bool inside = IsInside(views, grid.CellCenter(x, y, z), radius, min_views);
        grid.inside[grid.Index(x, y, z)] = inside ? 1 : 0;
      }
    }
  });
  return grid;
}

// The point nearest to all optical axes: sum_i (I - d_i d_i^T) (p - o_i) = 0. Nothing if they are
// parallel.
std::optional<glm::dvec3> LookAtPoint(std::span<const AlphaMask> masks) {
  glm::dmat3 matrix(0.0);
  glm::dvec3 right(0.0);
  for (const AlphaMask& mask : masks) {
    const Rigid3 world_from_cam = mask.cam_from_world.Inverse();
    const glm::dvec3 axis = world_from_cam.rotation[2];
    const glm::dmat3 projector = glm::dmat3(1.0) - glm::outerProduct(axis, axis);
    matrix += projector;
    right += projector * world_from_cam.translation;
  }
  matrix /= double(masks.size());
  // The determinant is about the squared angle [rad] between the axes: 1e-6 is a twentieth of a
  // degree.
  if (!(glm::determinant(matrix) > 1e-6)) return std::nullopt;
  return glm::inverse(matrix) * (right / double(masks.size()));
}

[[noreturn]] void FailLookAt(size_t count, const char* look) {
  throw DataError(fmt::format(
      "the {} training cameras look {}, not at one place that their alpha could be carved around; "
      "give the subject's bounds (triangulated points do not help: alpha takes precedence)",
      count, look));
}

// The cube around the look-at point that is as wide as the widest view there, from corner to
// corner.
Bounds3 BoxAroundLookAt(std::span<const AlphaMask> masks) {
  const std::optional<glm::dvec3> center = LookAtPoint(masks);
  if (!center) FailLookAt(masks.size(), "along one line");
  double half_side = 0;
  for (const AlphaMask& mask : masks) {
    const double distance = (mask.cam_from_world * *center).z;
    const Camera& camera = mask.camera;
    const glm::dvec3 corner = camera.CamFromImage({camera.width, camera.height});
    half_side = std::max(half_side, distance * glm::length(glm::dvec2(corner)));
  }
  if (!(half_side > 0)) FailLookAt(masks.size(), "away from each other");
  return {*center - half_side, *center + half_side};
}

// Carves three times, each time only the box that the previous pass left. May return an empty box.
Bounds3 ShrinkToInside(std::span<const MaskLookup> views, const Bounds3& search_box,
                       int min_views) {
  constexpr int kCells = 64;
  Bounds3 box = search_box;
  for (int pass = 0; pass < 3; ++pass) {
    const OccupancyGrid grid = Carve(views, box, CubicCells(box, kCells), min_views);
    const Bounds3 inside = grid.InsideBounds();
    if (inside.IsEmpty()) return inside;
    // One cell more, because the cells of the next grid are placed differently.
    const glm::dvec3 border = pass < 2 ? grid.CellSize() : glm::dvec3(0.0);
    box = {glm::max(inside.min - border, search_box.min),
           glm::min(inside.max + border, search_box.max)};
  }
  return box;
}

bool RayMeetsBox(const glm::dvec3& origin, const glm::dvec3& direction, const Bounds3& box) {
  // Division by zero is intended: a ray parallel to a slab gives infinities of the right sign.
  const glm::dvec3 to_min = (box.min - origin) / direction;
  const glm::dvec3 to_max = (box.max - origin) / direction;
  const glm::dvec3 enter = glm::min(to_min, to_max), leave = glm::max(to_min, to_max);
  return std::max({enter.x, enter.y, enter.z, 0.0}) <= std::min({leave.x, leave.y, leave.z});
}

// True if the rays through all pixels of at least half opacity meet the box, that is, no part of
// the subject that any image shows is outside it.
bool ExplainsMasks(std::span<const AlphaMask> masks, const Bounds3& box) {
  if (box.IsEmpty()) return false;
  std::atomic<bool> explained{true};
  ParallelFor(masks.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end && explained; ++i) {
      const Camera& camera = masks[i].camera;
      const Rigid3 world_from_cam = masks[i].cam_from_world.Inverse();
      for (size_t pixel = 0; pixel < masks[i].alpha.size(); ++pixel) {
        if (masks[i].alpha[pixel] < 128) continue;
        const glm::dvec2 center(double(pixel % size_t(camera.width)) + 0.5,
                                double(pixel / size_t(camera.width)) + 0.5);
        const glm::dvec3 direction = world_from_cam.rotation * camera.CamFromImage(center);
        if (!RayMeetsBox(world_from_cam.translation, direction, box)) explained = false;
      }
    }
  });
  return explained;
}

}  // namespace

std::vector<AlphaMask> ReadTrainingMasks(const std::filesystem::path& folder, const Scene& scene) {
  if (!scene.has_alpha) {
    throw DataError(fmt::format("{}: its images have no alpha, which carving needs",
                                (folder / "scene.json").string()));
  }
  const std::vector<int> training = scene.ViewsOf(Split::kTrain);
  std::vector<AlphaMask> masks(training.size());
  ParallelFor(training.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const View& view = scene.views[size_t(training[i])];
      const Camera& camera = scene.cameras[size_t(view.camera)];
      const std::filesystem::path path = folder / view.image;
      const Image image = ReadImage(path);
      if (image.channels != 4 || image.width != camera.width || image.height != camera.height) {
        throw DataError(fmt::format("{}: {} x {} pixels of {} channels; expected {} x {} of 4",
                                    path.string(), image.width, image.height, image.channels,
                                    camera.width, camera.height));
      }
      masks[i] = {camera, view.cam_from_world, AlphaOf(image)};
    }
  });
  return masks;
}

OccupancyGrid CarveMasks(std::span<const AlphaMask> masks, const Bounds3& bounds,
                         const glm::ivec3& size, int min_views) {
  TETREC_CHECK(size.x > 0 && size.y > 0 && size.z > 0 && !bounds.IsEmpty(), "empty grid");
  for (const AlphaMask& mask : masks) {
    TETREC_CHECK(mask.alpha.size() == size_t(mask.camera.width) * size_t(mask.camera.height),
                 fmt::format("mask of {} pixels", mask.alpha.size()));
  }
  return Carve(MakeLookups(masks), bounds, size, min_views);
}

std::optional<Bounds3> BoxSeenByAll(std::span<const AlphaMask> masks) {
  const std::optional<glm::dvec3> center = LookAtPoint(masks);
  if (!center) return std::nullopt;
  double radius = INFINITY;
  for (const AlphaMask& mask : masks) {
    const Camera& camera = mask.camera;
    const glm::dvec3 center_in_cam = mask.cam_from_world * *center;
    // Distances from the centre to the planes through the camera and the sides of its image.
    const glm::dvec3 top_left = camera.CamFromImage({0, 0});
    const glm::dvec3 bottom_right = camera.CamFromImage({camera.width, camera.height});
    for (const glm::dvec3& inward :
         {glm::dvec3(1, 0, -top_left.x), glm::dvec3(-1, 0, bottom_right.x),
          glm::dvec3(0, 1, -top_left.y), glm::dvec3(0, -1, bottom_right.y)}) {
      radius = std::min(radius, glm::dot(glm::normalize(inward), center_in_cam));
    }
  }
  if (!(radius > 0)) return std::nullopt;
  const double half_side = radius / std::sqrt(3.0);
  return Bounds3{*center - half_side, *center + half_side};
}

Bounds3 BoxAroundCameras(std::span<const AlphaMask> masks) {
  constexpr double kOnePlace = 1e-9;  // relative to the coordinates: their rounding
  Bounds3 box;
  for (const AlphaMask& mask : masks) box.Add(mask.cam_from_world.Inverse().translation);
  const glm::dvec3 size = box.Size();
  const double longest = std::max({size.x, size.y, size.z});
  if (!(longest > kOnePlace * std::max(glm::length(box.min), glm::length(box.max)))) {
    throw DataError(fmt::format(
        "the training cameras ({}) are all at one place, from which neither carving nor "
        "triangulation can find depth; add images from other places, or give the subject's bounds",
        masks.size()));
  }
  return {box.min - longest, box.max + longest};
}

Bounds3 FindSubjectBounds(std::span<const AlphaMask> masks, double margin) {
  const Bounds3 search_box = BoxAroundLookAt(masks);
  const std::vector<MaskLookup> views = MakeLookups(masks);
  const int count = int(masks.size());
  Bounds3 box;
  for (const int min_views : {(count + 1) / 2, (count + 3) / 4, 1, 0}) {
    box = ShrinkToInside(views, search_box, min_views);
    if (ExplainsMasks(masks, box)) break;
  }
  if (box.IsEmpty()) {
    throw DataError(
        fmt::format("the alpha masks of the {} training views have nothing in common; check that "
                    "poses and images belong together and that alpha is not 0 everywhere",
                    masks.size()));
  }
  const bool touches = glm::any(glm::lessThanEqual(box.min, search_box.min)) ||
                       glm::any(glm::greaterThanEqual(box.max, search_box.max));
  if (touches)
    LogWarning("the subject fills everything that the cameras see, and so do its bounds");
  const glm::dvec3 size = box.Size();
  const double grow = margin * std::max({size.x, size.y, size.z});
  return {box.min - grow, box.max + grow};
}

}  // namespace tetrec
