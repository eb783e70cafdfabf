// One cloud of points from the depth maps of all views.
#include "stereo/fusion.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/ply.h"
#include "core/random.h"
#include "stereo/consistency.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetrec {
namespace {

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

uint8_t MedianByte(std::vector<uint8_t>& values) {
  const auto middle = values.begin() + std::ptrdiff_t(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
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

Cell CellOf(const glm::dvec3& position, double footprint, double spacing_px) {
  Cell cell;
  cell.level = int(std::ceil(2 * std::log2(spacing_px * footprint)));
  cell.at = glm::i64vec3(glm::floor(position / SideOf(cell.level)));
  return cell;
}

uint64_t HashOf(const Cell& cell) {
  auto hash = uint64_t(cell.level);
  for (int axis = 0; axis < 3; ++axis) hash = Random(hash, uint64_t(cell.at[axis])).Next();
  return hash;
}

// A pixel with a depth, in the cell of its point.
struct CellPixel {
  Cell cell;
  uint32_t view;   // position in the views
  uint32_t index;  // in the view's map
  bool operator<(const CellPixel& other) const {
    return std::tie(cell, view, index) < std::tie(other.cell, other.view, other.index);
  }
};

// A share of all cells, by their hash: the pixels of all maps together may not fit into memory.
struct Part {
  uint64_t index, count;
  bool Contains(const Cell& cell) const { return count == 1 || HashOf(cell) % count == index; }
};

// The depth maps and the poses that place them in the world.
class Depths {
 public:
  Depths(std::span<const StereoDepth> maps, std::span<const StereoView> views)
      : maps_(maps), views_(views) {
    for (const StereoView& view : views) world_from_cam_.push_back(view.cam_from_world.Inverse());
  }

  // The number of pixels with a depth.
  uint64_t Count() const {
    uint64_t count = 0;
    for (const StereoDepth& map : maps_) count += CountDepths(map);
    return count;
  }

  // The pixels with a depth whose cells are in the part, by cells.
  std::vector<CellPixel> PixelsOf(const Part& part, double spacing_px) const {
    std::vector<std::vector<CellPixel>> of_views(maps_.size());
    ParallelFor(maps_.size(), 1, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) of_views[i] = PixelsOf(part, spacing_px, uint32_t(i));
    });
    std::vector<CellPixel> pixels;
    size_t count = 0;
    for (const std::vector<CellPixel>& of_view : of_views) count += of_view.size();
    pixels.reserve(count);
    for (std::vector<CellPixel>& of_view : of_views) {
      pixels.insert(pixels.end(), of_view.begin(), of_view.end());
      of_view = {};
    }
    std::sort(pixels.begin(), pixels.end());
    return pixels;
  }

  // The mean of a cell's pixels.
  DensePoint MeanOf(std::span<const CellPixel> cell) const {
    DensePoint point;
    point.spacing = SideOf(cell[0].cell.level);
    std::array<std::vector<uint8_t>, 3> colors;
    for (const CellPixel& pixel : cell) {
      point.position += PositionOf(pixel) / double(cell.size());
      point.normal += NormalOf(pixel);
      const uint8_t* color =
          &views_[pixel.view].image.pixels[size_t(pixel.index) * views_[pixel.view].image.channels];
      for (size_t c = 0; c < 3; ++c) colors[c].push_back(color[c]);
    }
    const double length = glm::length(point.normal);
    point.normal = length > 0 ? point.normal / length : NormalOf(cell[0]);
    for (size_t c = 0; c < 3; ++c) point.color_srgb[c] = MedianByte(colors[c]);
    return point;
  }

 private:
  std::vector<CellPixel> PixelsOf(const Part& part, double spacing_px, uint32_t view) const {
    std::vector<CellPixel> pixels;
    const StereoDepth& map = maps_[view];
    for (int y = 0; y < map.camera.height; ++y) {
      for (int x = 0; x < map.camera.width; ++x) {
        glm::dvec3 in_cam;
        if (!PointOf(map, x, y, in_cam)) continue;
        // At the point's depth, a pixel has a side of z / fx.
        const Cell cell =
            CellOf(world_from_cam_[view] * in_cam, in_cam.z / map.camera.fx, spacing_px);
        if (part.Contains(cell)) pixels.push_back({cell, view, uint32_t(map.Index(x, y))});
      }
    }
    return pixels;
  }

  glm::dvec3 InCam(const CellPixel& pixel, int& x, int& y) const {
    const StereoDepth& map = maps_[pixel.view];
    x = int(pixel.index) % map.camera.width;
    y = int(pixel.index) / map.camera.width;
    glm::dvec3 in_cam;
    PointOf(map, x, y, in_cam);
    return in_cam;
  }

  glm::dvec3 PositionOf(const CellPixel& pixel) const {
    int x, y;
    return world_from_cam_[pixel.view] * InCam(pixel, x, y);
  }

  glm::dvec3 NormalOf(const CellPixel& pixel) const {
    int x, y;
    const glm::dvec3 in_cam = InCam(pixel, x, y);
    return world_from_cam_[pixel.view].rotation * NormalInCam(maps_[pixel.view], x, y, in_cam);
  }

  std::span<const StereoDepth> maps_;
  std::span<const StereoView> views_;
  std::vector<Rigid3> world_from_cam_;
};

// Calls `use` with the pixels of each cell.
template <class Use>
void ForEachCell(std::span<const CellPixel> sorted, const Use& use) {
  for (size_t begin = 0; begin < sorted.size();) {
    size_t end = begin + 1;
    while (end < sorted.size() && sorted[end].cell == sorted[begin].cell) ++end;
    use(sorted.subspan(begin, end - begin));
    begin = end;
  }
}

// The number of cells that a surface fills falls with the square of their side. It does not fall
// below a few cells of each level. The count of one of `parts` parts is scaled up to all cells.
double FindSpacing(const Depths& depths, uint64_t parts, size_t max_points) {
  constexpr double kWidest_px = 1e6;
  double spacing_px = 1;
  for (int i = 0; spacing_px < kWidest_px; ++i) {
    uint64_t count = 0;
    ForEachCell(depths.PixelsOf({0, parts}, spacing_px), [&](auto) { count += parts; });
    if (count <= max_points) break;
    const double least_growth = i < 6 ? 1.03 : 2;
    spacing_px *= std::max(least_growth, std::sqrt(double(count) / double(max_points)));
  }
  return spacing_px;
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
  TETREC_CHECK(options.max_points > 0 && options.pixels_at_once > 0, "points to fuse");
  const Depths depths(maps, views);
  Fusion fusion;
  fusion.pixels = depths.Count();
  if (fusion.pixels == 0) return fusion;
  const uint64_t parts = 1 + fusion.pixels / options.pixels_at_once;
  fusion.spacing_px = FindSpacing(depths, parts, options.max_points);
  for (uint64_t part = 0; part < parts; ++part) {
    ForEachCell(depths.PixelsOf({part, parts}, fusion.spacing_px),
                [&](std::span<const CellPixel> cell) {
                  DensePoint point = depths.MeanOf(cell);
                  if (FindViews(point, maps, views, options.see_through)) {
                    fusion.points.push_back(std::move(point));
                  } else {
                    ++fusion.contradicted;
                  }
                });
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
