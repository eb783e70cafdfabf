// The first mesh and field from a dense cloud of points.
#include "start/dense_start.h"

#include "core/error.h"
#include "core/quantile.h"
#include "mesh/delaunay.h"
#include "start/free_space.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace tetrec {
namespace {

enum class Layer { kSurface, kFront, kBehind, kSparse };

// A vertex that comes from a point.
struct Source {
  Layer layer = Layer::kSurface;
  uint32_t point = 0;  // of the dense points, or of the sparse ones
};

struct Vertices {
  std::vector<glm::dvec3> positions;
  std::vector<Source> sources;
};

// Hash grid over the dense points, to find whether one is near.
class NearPoints {
 public:
  explicit NearPoints(std::span<const DensePoint> points) : points_(points) {
    for (const DensePoint& point : points) side_ = std::max(side_, point.spacing);
    if (!(side_ > 0)) side_ = 1;
    for (uint32_t i = 0; i < points.size(); ++i) {
      cells_.push_back({KeyOf(CellOf(points[i].position)), i});
    }
    std::sort(cells_.begin(), cells_.end());
  }
  // True if a point other than `except` is closer than `share` of its spacing.
  bool HasNear(const glm::dvec3& at, double share, uint32_t except) const {
    const glm::i64vec3 cell = CellOf(at);
    const int64_t reach = int64_t(std::ceil(share));
    for (int64_t z = -reach; z <= reach; ++z) {
      for (int64_t y = -reach; y <= reach; ++y) {
        for (int64_t x = -reach; x <= reach; ++x) {
          if (IsNearIn(KeyOf(cell + glm::i64vec3(x, y, z)), at, share, except)) return true;
        }
      }
    }
    return false;
  }

 private:
  glm::i64vec3 CellOf(const glm::dvec3& p) const { return glm::i64vec3(glm::floor(p / side_)); }
  static uint64_t KeyOf(const glm::i64vec3& cell) {
    return uint64_t(cell.x) * 73856093u ^ uint64_t(cell.y) * 19349663u ^
           uint64_t(cell.z) * 83492791u;
  }
  bool IsNearIn(uint64_t key, const glm::dvec3& at, double share, uint32_t except) const {
    auto entry = std::lower_bound(cells_.begin(), cells_.end(), std::pair(key, 0u));
    for (; entry != cells_.end() && entry->first == key; ++entry) {
      const DensePoint& point = points_[entry->second];
      if (entry->second != except && glm::distance(point.position, at) < share * point.spacing) {
        return true;
      }
    }
    return false;
  }

  std::span<const DensePoint> points_;
  double side_ = 0;
  std::vector<std::pair<uint64_t, uint32_t>> cells_;
};

// The points, the layers before and behind them, and the sparse points where no dense one is near.
Vertices LayeredVertices(std::span<const DensePoint> points, std::span<const ScenePoint> sparse,
                         const DenseStartOptions& options) {
  constexpr double kTooNear = 0.5;
  const NearPoints near(points);
  Vertices vertices;
  const auto add = [&](const glm::dvec3& position, Layer layer, uint32_t point) {
    vertices.positions.push_back(position);
    vertices.sources.push_back({layer, point});
  };
  for (uint32_t i = 0; i < points.size(); ++i) {
    add(points[i].position, Layer::kSurface, i);
    const glm::dvec3 offset = options.layer_spacing * points[i].spacing * points[i].normal;
    const glm::dvec3 front = points[i].position + offset, behind = points[i].position - offset;
    if (!near.HasNear(front, kTooNear, i)) add(front, Layer::kFront, i);
    if (!near.HasNear(behind, kTooNear, i)) add(behind, Layer::kBehind, i);
  }
  for (uint32_t i = 0; i < sparse.size(); ++i) {
    if (!near.HasNear(sparse[i].position, 2.0, kNoPoint)) {
      add(sparse[i].position, Layer::kSparse, i);
    }
  }
  return vertices;
}

glm::vec3 AsColor(const std::array<uint8_t, 3>& rgb) {
  return glm::vec3(rgb[0], rgb[1], rgb[2]) / 255.0f;
}

// Any tet of each vertex.
std::vector<uint32_t> TetOfVertex(const TetMesh& mesh) {
  std::vector<uint32_t> tet_of(mesh.positions.size(), 0);
  for (uint32_t t = 0; t < mesh.tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) tet_of[mesh.tets[t][i]] = t;
  }
  return tet_of;
}

// What the tets around a vertex are.
struct Surroundings {
  uint32_t full = 0, crossed = 0, tets = 0;
};

std::vector<Surroundings> LookAround(const TetMesh& mesh, const FreeSpace& space) {
  std::vector<Surroundings> around(mesh.positions.size());
  for (size_t t = 0; t < mesh.tets.size(); ++t) {
    for (int i = 0; i < 4; ++i) {
      Surroundings& vertex = around[mesh.tets[t][i]];
      ++vertex.tets;
      vertex.full += space.is_full[t];
      vertex.crossed += space.crossings[t] > 0 ? 1 : 0;
    }
  }
  return around;
}

double OpticalDepth(VertexKind kind, const Source* source, const Surroundings& around,
                    const DenseStartOptions& options, const InitialFieldOptions& field) {
  if (kind == VertexKind::kFar || kind == VertexKind::kCorner) return field.far_optical_depth;
  const bool is_free = around.full == 0 && 2 * around.crossed >= around.tets;
  if (source == nullptr) return is_free ? options.free_depth : field.fill_optical_depth;
  switch (source->layer) {
    case Layer::kSurface:
    case Layer::kBehind:
      return around.full > 0 ? options.surface_depth : field.fill_optical_depth;
    case Layer::kFront:
      return options.free_depth;
    case Layer::kSparse:
      return field.point_optical_depth;
  }
  TETREC_CHECK(false, "a vertex of unknown layer");
}

bool IsDeepInside(const Surroundings& around) {
  return around.full == around.tets && around.crossed == 0;
}

// No photo sees the inside of the subject, so nothing would ever fill it: the surface would have a
// back. It starts as dense as the layer behind the surface.
void FillSubject(RadianceField& field, std::span<const Source* const> sources,
                 std::span<const Surroundings> around, const Bounds3& subject) {
  std::vector<double> behind;
  for (size_t v = 0; v < sources.size(); ++v) {
    const bool is_behind = sources[v] != nullptr && sources[v]->layer == Layer::kBehind;
    if (is_behind && around[v].full > 0) behind.push_back(field.density[v]);
  }
  if (behind.empty()) return;
  const float density = float(Quantile(std::move(behind), 0.5));
  for (size_t v = 0; v < sources.size(); ++v) {
    if (IsDeepInside(around[v]) && subject.Contains(glm::dvec3(field.mesh.positions[v]))) {
      field.density[v] = std::max(field.density[v], density);
    }
  }
}

}  // namespace

DenseStart StartFromDense(std::span<const DensePoint> points, std::span<const ScenePoint> sparse,
                          std::span<const glm::dvec3> centers,
                          std::span<const glm::dvec3> all_cameras, const Bounds3& subject,
                          const PointStartOptions& shell, const DenseStartOptions& options,
                          const InitialFieldOptions& field, uint64_t seed) {
  const Vertices vertices = LayeredVertices(points, sparse, options);
  const PointStart start = StartFromPoints(vertices.positions, all_cameras, subject, shell, seed);
  DelaunayResult delaunay = BuildDelaunay(start.points.positions);
  const TetMesh& mesh = delaunay.mesh;

  DenseStart result;
  result.fill = start.fill;
  result.dropped_far = start.dropped_far;
  result.far_radius = start.far_radius;
  const std::vector<uint32_t> tet_of = TetOfVertex(mesh);
  std::vector<VertexKind> kinds;
  std::vector<const Source*> sources;
  std::vector<std::optional<glm::vec3>> colors;
  std::vector<SightLine> lines;
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const uint32_t p = delaunay.point_of_vertex[v];
    kinds.push_back(start.points.kinds[p]);
    const uint32_t index = start.points.point[p];
    const Source* source = index == kNoPoint ? nullptr : &vertices.sources[index];
    sources.push_back(source);
    colors.emplace_back();
    if (source == nullptr) continue;
    if (source->layer == Layer::kSparse) {
      colors.back() = AsColor(sparse[source->point].color_srgb);
      continue;
    }
    const DensePoint& point = points[source->point];
    colors.back() = AsColor(point.color_srgb);
    result.surface += source->layer == Layer::kSurface ? 1 : 0;
    result.front += source->layer == Layer::kFront ? 1 : 0;
    result.behind += source->layer == Layer::kBehind ? 1 : 0;
    if (source->layer != Layer::kSurface) continue;
    for (const uint32_t view : point.views) {
      lines.push_back({point.position, centers[view], point.spacing, tet_of[v]});
    }
  }
  result.sight_lines = lines.size();
  const FreeSpace space = LabelFreeSpace(mesh, lines);
  result.lost_lines = space.lost_lines;
  result.full_tets = uint64_t(std::count(space.is_full.begin(), space.is_full.end(), uint8_t{1}));
  result.free_tets = mesh.tets.size() - result.full_tets;

  const std::vector<Surroundings> around = LookAround(mesh, space);
  std::vector<double> optical_depths;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    optical_depths.push_back(OpticalDepth(kinds[v], sources[v], around[v], options, field));
    const bool is_point = sources[v] != nullptr && sources[v]->layer == Layer::kSurface;
    result.free_points += is_point && around[v].full == 0 ? 1 : 0;
  }
  result.field = MakeFieldByDepth(std::move(delaunay.mesh), optical_depths, colors);
  FillSubject(result.field, sources, around, subject);
  return result;
}

}  // namespace tetrec
