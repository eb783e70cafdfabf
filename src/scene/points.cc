// Sparse points in PLY files.
#include "scene/points.h"

#include "core/error.h"
#include "core/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tetrec {
namespace {

constexpr double kFar = kFarthestPoint;

// The scalar properties of a file's vertices, by name.
class VertexColumns {
 public:
  explicit VertexColumns(const std::filesystem::path& path)
      : path_(path.string()), ply_(ReadPly(path)), vertex_(ply_.Find("vertex")) {
    if (vertex_ == nullptr) throw DataError(fmt::format("{}: has no vertices", path_));
  }

  size_t count() const { return vertex_->count; }
  // Throws unless all values are in [min, max].
  const std::vector<double>& Get(const char* name, double min, double max) const {
    const PlyProperty* property = vertex_->Find(name);
    if (property == nullptr || property->is_list) {
      throw DataError(fmt::format(
          "{}: vertex property '{}' is missing; expected x y z and red green blue", path_, name));
    }
    for (size_t i = 0; i < property->values.size(); ++i) {
      const double value = property->values[i];
      if (!(value >= min && value <= max)) {
        throw DataError(fmt::format("{}: {} of vertex {} is {}; expected {} to {}", path_, name, i,
                                    value, min, max));
      }
    }
    return property->values;
  }
  // Some programs write colours as floating-point numbers of 0 to 1, others as floating-point
  // numbers of 0 to 255.
  bool HasUnitColors() const {
    for (const char* name : {"red", "green", "blue"}) {
      const PlyProperty& property = *vertex_->Find(name);
      if (property.type != PlyType::kFloat && property.type != PlyType::kDouble) return false;
      if (std::any_of(property.values.begin(), property.values.end(),
                      [](double value) { return value > 1; }))
        return false;
    }
    return true;
  }

 private:
  std::string path_;
  PlyFile ply_;
  const PlyElement* vertex_;
};

std::vector<ScenePoint> PositionsAndColors(const VertexColumns& vertex) {
  const auto& x = vertex.Get("x", -kFar, kFar);
  const auto& y = vertex.Get("y", -kFar, kFar);
  const auto& z = vertex.Get("z", -kFar, kFar);
  const auto& red = vertex.Get("red", 0, 255);
  const auto& green = vertex.Get("green", 0, 255);
  const auto& blue = vertex.Get("blue", 0, 255);
  const double unit = vertex.HasUnitColors() ? 255 : 1;
  const auto to_byte = [&](double value) { return uint8_t(std::lround(value * unit)); };
  std::vector<ScenePoint> points(vertex.count());
  for (size_t i = 0; i < points.size(); ++i) {
    points[i].position = {x[i], y[i], z[i]};
    points[i].color_srgb = {to_byte(red[i]), to_byte(green[i]), to_byte(blue[i])};
  }
  return points;
}

}  // namespace

std::vector<ScenePoint> ReadScenePoints(const std::filesystem::path& path) {
  const VertexColumns vertex(path);
  std::vector<ScenePoint> points = PositionsAndColors(vertex);
  const auto& error = vertex.Get("reprojection_error", 0, kFar);
  const auto& track = vertex.Get("track_length", 0, kFar);
  for (size_t i = 0; i < points.size(); ++i) {
    points[i].reprojection_error_px = float(error[i]);
    points[i].track_length = uint32_t(track[i]);
  }
  return points;
}

std::vector<ScenePoint> ReadColoredPoints(const std::filesystem::path& path) {
  return PositionsAndColors(VertexColumns(path));
}

void WriteScenePoints(const std::filesystem::path& path, const std::vector<ScenePoint>& points) {
  PlyElement vertex{"vertex", points.size(), {}};
  const auto add = [&](const char* name, PlyType type, auto&& value_of) {
    PlyProperty property;
    property.name = name;
    property.type = type;
    property.values.reserve(points.size());
    for (const ScenePoint& point : points) property.values.push_back(double(value_of(point)));
    vertex.properties.push_back(std::move(property));
  };
  add("x", PlyType::kDouble, [](const ScenePoint& p) { return p.position.x; });
  add("y", PlyType::kDouble, [](const ScenePoint& p) { return p.position.y; });
  add("z", PlyType::kDouble, [](const ScenePoint& p) { return p.position.z; });
  add("red", PlyType::kUint8, [](const ScenePoint& p) { return p.color_srgb[0]; });
  add("green", PlyType::kUint8, [](const ScenePoint& p) { return p.color_srgb[1]; });
  add("blue", PlyType::kUint8, [](const ScenePoint& p) { return p.color_srgb[2]; });
  add("reprojection_error", PlyType::kFloat,
      [](const ScenePoint& p) { return p.reprojection_error_px; });
  add("track_length", PlyType::kUint32, [](const ScenePoint& p) { return p.track_length; });
  WritePly(path, {{}, {std::move(vertex)}});
}

}  // namespace tetrec
