// One cloud of points from the depth maps of all views.
#include "stereo/fusion.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/ply.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetrec {
namespace {

// A depth as a point, before thinning.
struct Sample {
  glm::dvec3 position{0.0}, normal{0.0};
  double footprint = 0;  // side of the pixel at the point's depth [world units]
  std::array<uint8_t, 3> color_srgb{0, 0, 0};
  uint32_t view = 0;
};

// The point of a pixel, if it has a depth.
bool PointOf(const StereoDepth& map, int x, int y, glm::dvec3& in_cam) {
  if (x < 0 || y < 0 || x >= map.camera.width || y >= map.camera.height) return false;
  const double depth = map.depth[map.Index(x, y)];
  in_cam = depth * map.camera.CamFromImage({x + 0.5, y + 0.5});
  return depth > 0;
}

// From the points of the pixels around, if they are on one surface; otherwise towards the camera.
glm::dvec3 NormalInCam(const StereoDepth& map, int x, int y, const glm::dvec3& in_cam) {
  const glm::dvec3 towards_camera = -glm::normalize(in_cam);
  glm::dvec3 left, right, up, down;
  if (!PointOf(map, x - 1, y, left) || !PointOf(map, x + 1, y, right) ||
      !PointOf(map, x, y - 1, up) || !PointOf(map, x, y + 1, down)) {
    return towards_camera;
  }
  constexpr double kOneSurface = 0.05;  // relative difference of depths across two pixels
  if (std::abs(left.z - right.z) > kOneSurface * in_cam.z ||
      std::abs(up.z - down.z) > kOneSurface * in_cam.z) {
    return towards_camera;
  }
  const glm::dvec3 normal = glm::cross(down - up, right - left);
  const double length = glm::length(normal);
  if (!(length > 0)) return towards_camera;
  return glm::dot(normal, towards_camera) < 0 ? -normal / length : normal / length;
}

std::vector<Sample> SamplesOf(const StereoDepth& map, const StereoView& view, uint32_t index) {
  std::vector<Sample> samples;
  const Rigid3 world_from_cam = view.cam_from_world.Inverse();
  for (int y = 0; y < map.camera.height; ++y) {
    for (int x = 0; x < map.camera.width; ++x) {
      glm::dvec3 in_cam;
      if (!PointOf(map, x, y, in_cam)) continue;
      Sample sample;
      sample.position = world_from_cam * in_cam;
      sample.normal = world_from_cam.rotation * NormalInCam(map, x, y, in_cam);
      sample.footprint = in_cam.z / map.camera.fx;
      const uint8_t* pixel = view.image.At(x, y);
      sample.color_srgb = {pixel[0], pixel[1], pixel[2]};
      sample.view = index;
      samples.push_back(sample);
    }
  }
  return samples;
}

// Cells have sides of powers of the square root of 2, the next one above `spacing_px` footprints.
struct Cell {
  int level = 0;
  glm::i64vec3 at{0};
  bool operator==(const Cell&) const = default;
  bool operator<(const Cell& other) const {
    return std::tie(level, at.x, at.y, at.z) <
           std::tie(other.level, other.at.x, other.at.y, other.at.z);
  }
};

double SideOf(int level) { return std::exp2(0.5 * level); }

Cell CellOf(const Sample& sample, double spacing_px) {
  Cell cell;
  cell.level = int(std::ceil(2 * std::log2(spacing_px * sample.footprint)));
  cell.at = glm::i64vec3(glm::floor(sample.position / SideOf(cell.level)));
  return cell;
}

struct CellSample {
  Cell cell;
  uint32_t sample;
  bool operator<(const CellSample& other) const {
    return cell == other.cell ? sample < other.sample : cell < other.cell;
  }
};

std::vector<CellSample> SortIntoCells(std::span<const Sample> samples, double spacing_px) {
  std::vector<CellSample> sorted(samples.size());
  ParallelFor(samples.size(), 1 << 14, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) sorted[i] = {CellOf(samples[i], spacing_px), uint32_t(i)};
  });
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

size_t CountCells(std::span<const CellSample> sorted) {
  size_t count = sorted.empty() ? 0 : 1;
  for (size_t i = 1; i < sorted.size(); ++i) count += sorted[i].cell == sorted[i - 1].cell ? 0 : 1;
  return count;
}

// The number of cells that a surface fills falls with the square of their side. It does not fall
// below a few cells of each level.
double FindSpacing(std::span<const Sample> samples, size_t max_points) {
  constexpr double kWidest_px = 1e6;
  double spacing_px = 1;
  for (int i = 0; spacing_px < kWidest_px; ++i) {
    const size_t count = CountCells(SortIntoCells(samples, spacing_px));
    if (count <= max_points) break;
    const double least_growth = i < 6 ? 1.03 : 2;
    spacing_px *= std::max(least_growth, std::sqrt(double(count) / double(max_points)));
  }
  return spacing_px;
}

uint8_t MedianByte(std::vector<uint8_t>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

DensePoint MeanOf(std::span<const Sample> samples, std::span<const CellSample> cell) {
  DensePoint point;
  point.spacing = SideOf(cell[0].cell.level);
  std::array<std::vector<uint8_t>, 3> colors;
  for (const CellSample& entry : cell) {
    const Sample& sample = samples[entry.sample];
    point.position += sample.position / double(cell.size());
    point.normal += sample.normal;
    for (size_t c = 0; c < 3; ++c) colors[c].push_back(sample.color_srgb[c]);
  }
  const double length = glm::length(point.normal);
  point.normal = length > 0 ? point.normal / length : samples[cell[0].sample].normal;
  for (size_t c = 0; c < 3; ++c) point.color_srgb[c] = MedianByte(colors[c]);
  return point;
}

enum class Verdict { kNone, kSees, kSeesThrough };

Verdict Judge(const DensePoint& point, const StereoDepth& map, const StereoView& view,
              double see_through) {
  const glm::dvec3 in_cam = view.cam_from_world * point.position;
  if (!map.camera.Shows(in_cam)) return Verdict::kNone;
  const glm::dvec2 pixel = map.camera.ImageFromCam(in_cam);
  const double depth = map.depth[map.Index(int(pixel.x), int(pixel.y))];
  if (!(depth > 0)) return Verdict::kNone;
  if (depth > (1 + see_through) * in_cam.z + point.spacing) return Verdict::kSeesThrough;
  return depth < in_cam.z - point.spacing ? Verdict::kNone : Verdict::kSees;
}

// Fills in the views that see the point; false if as many see through it.
bool FindViews(DensePoint& point, std::span<const StereoDepth> maps,
               std::span<const StereoView> views, double see_through) {
  size_t contradicting = 0;
  for (size_t i = 0; i < maps.size(); ++i) {
    const Verdict verdict = Judge(point, maps[i], views[i], see_through);
    if (verdict == Verdict::kSees) point.views.push_back(uint32_t(i));
    contradicting += verdict == Verdict::kSeesThrough ? 1 : 0;
  }
  return point.views.size() > contradicting;
}

PlyProperty Property(const char* name, PlyType type) {
  PlyProperty property;
  property.name = name;
  property.type = type;
  return property;
}

}  // namespace

Fusion FuseDepths(std::span<const StereoDepth> maps, std::span<const StereoView> views,
                  const FusionOptions& options) {
  TETREC_CHECK(maps.size() == views.size(), "a map for each view");
  TETREC_CHECK(options.max_points > 0, "points to fuse");
  std::vector<std::vector<Sample>> by_view(maps.size());
  ParallelFor(maps.size(), 1, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) by_view[i] = SamplesOf(maps[i], views[i], uint32_t(i));
  });
  std::vector<Sample> samples;
  for (std::vector<Sample>& of_view : by_view) {
    samples.insert(samples.end(), of_view.begin(), of_view.end());
    of_view = {};
  }
  Fusion fusion;
  fusion.pixels = samples.size();
  if (samples.empty()) return fusion;
  fusion.spacing_px = FindSpacing(samples, options.max_points);
  const std::vector<CellSample> sorted = SortIntoCells(samples, fusion.spacing_px);
  for (size_t begin = 0; begin < sorted.size();) {
    size_t end = begin + 1;
    while (end < sorted.size() && sorted[end].cell == sorted[begin].cell) ++end;
    DensePoint point = MeanOf(samples, std::span(sorted).subspan(begin, end - begin));
    if (FindViews(point, maps, views, options.see_through)) {
      fusion.points.push_back(std::move(point));
    } else {
      ++fusion.contradicted;
    }
    begin = end;
  }
  return fusion;
}

void WriteDensePoints(const std::filesystem::path& path, std::span<const DensePoint> points) {
  PlyElement vertex;
  vertex.name = "vertex";
  vertex.count = points.size();
  for (const char* name : {"x", "y", "z", "nx", "ny", "nz"}) {
    vertex.properties.push_back(Property(name, PlyType::kFloat));
  }
  for (const char* name : {"red", "green", "blue"}) {
    vertex.properties.push_back(Property(name, PlyType::kUint8));
  }
  vertex.properties.push_back(Property("views", PlyType::kUint32));
  for (const DensePoint& point : points) {
    for (int i = 0; i < 3; ++i) {
      vertex.properties[size_t(i)].values.push_back(point.position[i]);
      vertex.properties[size_t(i) + 3].values.push_back(point.normal[i]);
      vertex.properties[size_t(i) + 6].values.push_back(double(point.color_srgb[size_t(i)]));
    }
    vertex.properties[9].values.push_back(double(point.views.size()));
  }
  PlyFile file;
  file.elements.push_back(std::move(vertex));
  WritePly(path, file);
}

}  // namespace tetrec
