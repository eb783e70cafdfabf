// True depths of views.
#include "eval/true_depth.h"

#include "core/error.h"
#include "image/image.h"
#include "image/pixels_around.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

namespace tetrec {
namespace {

double Cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

// The first and the last pixel whose centre lies between two coordinates, inside of `size` pixels;
// first > last if there is none.
std::pair<int, int> CentresBetween(double low, double high, int size) {
  const double first = std::clamp(std::ceil(low - 0.5), 0.0, double(size));
  const double last = std::clamp(std::floor(high - 0.5), -1.0, double(size - 1));
  return {int(first), int(last)};
}

// Keeps the nearest depth; 1 / depth is linear in the image.
void DrawTriangle(const std::array<glm::dvec3, 3>& in_cam, const Camera& camera, DepthMap& map) {
  std::array<glm::dvec2, 3> at;
  for (int i = 0; i < 3; ++i) at[i] = camera.ImageFromCam(in_cam[i]);
  const double area = Cross(at[1] - at[0], at[2] - at[0]);
  if (area == 0 || !std::isfinite(area)) return;
  const auto [x_low, x_high] = std::minmax({at[0].x, at[1].x, at[2].x});
  const auto [y_low, y_high] = std::minmax({at[0].y, at[1].y, at[2].y});
  const auto [x_first, x_last] = CentresBetween(x_low, x_high, map.width);
  const auto [y_first, y_last] = CentresBetween(y_low, y_high, map.height);
  for (int y = y_first; y <= y_last; ++y) {
    for (int x = x_first; x <= x_last; ++x) {
      const glm::dvec2 p(x + 0.5, y + 0.5);
      const double w0 = Cross(at[1] - p, at[2] - p) / area, w1 = Cross(at[2] - p, at[0] - p) / area;
      const double w2 = 1 - w0 - w1;
      if (w0 < 0 || w1 < 0 || w2 < 0) continue;
      const double depth = 1 / (w0 / in_cam[0].z + w1 / in_cam[1].z + w2 / in_cam[2].z);
      float& nearest = map.At(x, y);
      if (nearest == kNoDepth || depth < double(nearest)) nearest = float(depth);
    }
  }
}

void KeepInside(const Bounds3& bounds_in_truth, const Similarity3& truth_from_world,
                const Camera& camera, const Rigid3& world_from_cam, DepthMap& map) {
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      float& depth = map.At(x, y);
      if (depth == kNoDepth) continue;
      const glm::dvec3 in_cam = double(depth) * camera.CamFromImage({x + 0.5, y + 0.5});
      if (!bounds_in_truth.Contains(truth_from_world * (world_from_cam * in_cam))) depth = kNoDepth;
    }
  }
}

constexpr double kNerfRange = 8;  // [input units] at value 0
constexpr int kMostSteps = 4;     // between neighbours on one surface

// True if the pixel and its neighbours are on one surface.
bool IsOnOneSurface(const Image& map, int x, int y) {
  const int value = map.At(x, y)[0];
  for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, map.height - 1); ++ny) {
    for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, map.width - 1); ++nx) {
      const int neighbor = map.At(nx, ny)[0];
      if (neighbor == 0 || std::abs(neighbor - value) > kMostSteps) return false;
    }
  }
  return value > 0;
}

// The value of the map between the centres of its pixels; nothing beside a surface.
std::optional<double> ValueAt(const Image& map, const glm::dvec2& position) {
  double value = 0;
  for (const auto& [x, y, weight] : PixelsAround(map.width, map.height, position)) {
    if (weight == 0) continue;
    if (!IsOnOneSurface(map, x, y)) return std::nullopt;
    value += weight * map.At(x, y)[0];
  }
  return value;
}

}  // namespace

std::filesystem::path NerfMapFile(const std::filesystem::path& folder, const std::string& view,
                                  const std::string& what) {
  const std::filesystem::path stem = folder / view;
  const std::string start = stem.filename().string() + "_" + what + "_";
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(stem.parent_path(), error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with(start) && name.ends_with(".png")) return entry.path();
  }
  throw DataError(fmt::format("{}NNNN.png: there is no such {} map for view '{}'",
                              (stem.parent_path() / start).string(), what, view));
}

DepthMap ReadNerfDepth(const std::filesystem::path& folder, const std::string& view_name,
                       const Camera& camera, double world_from_input_scale) {
  const Image stored = ReadImage(NerfMapFile(folder, view_name, "depth"));
  DepthMap map = MakeDepthMap(camera.width, camera.height);
  for (int y = 0; y < map.height; ++y) {
    for (int x = 0; x < map.width; ++x) {
      const auto value = ValueAt(stored, {(x + 0.5) * stored.width / camera.width,
                                          (y + 0.5) * stored.height / camera.height});
      if (!value) continue;
      const double distance = world_from_input_scale * kNerfRange * (1 - *value / 255);
      map.At(x, y) = float(DepthOfDistance(camera, {x, y}, distance));
    }
  }
  return map;
}

MeshDepth DepthOfMesh(const TriangleMesh& mesh_in_truth, const Similarity3& truth_from_world,
                      const Bounds3& bounds_in_truth, const Camera& camera,
                      const Rigid3& cam_from_world) {
  const Similarity3 world_from_truth = truth_from_world.Inverse();
  std::vector<glm::dvec3> in_cam;
  for (const glm::vec3& position : mesh_in_truth.positions) {
    in_cam.push_back(cam_from_world * (world_from_truth * glm::dvec3(position)));
  }
  MeshDepth result{MakeDepthMap(camera.width, camera.height)};
  for (const glm::uvec3& triangle : mesh_in_truth.triangles) {
    const std::array<glm::dvec3, 3> corners = {in_cam[triangle.x], in_cam[triangle.y],
                                               in_cam[triangle.z]};
    const auto in_front = [](const glm::dvec3& corner) { return corner.z > 0; };
    const auto count = std::count_if(corners.begin(), corners.end(), in_front);
    if (count == 3) DrawTriangle(corners, camera, result.map);
    if (count == 1 || count == 2) ++result.cut_triangles;
  }
  KeepInside(bounds_in_truth, truth_from_world, camera, cam_from_world.Inverse(), result.map);
  return result;
}

}  // namespace tetrec
