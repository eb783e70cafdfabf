// The vertices of the first mesh.
#include "start/start_points.h"

#include "core/error.h"
#include "core/quantile.h"
#include "geometry/random_vectors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <tuple>
#include <unordered_map>

namespace tetrec {
namespace {

// Uniform in [-1, 1)^3.
glm::dvec3 RandomInCube(MersenneRandom& random) { return 2.0 * RandomInUnitCube(random) - 1.0; }

// Collects vertices of a box whose corners are exact floats.
class BoxPoints {
 public:
  explicit BoxPoints(const Bounds3& box) : low_(box.min), high_(box.max) {
    for (int i = 0; i < 8; ++i) {
      Append(
          glm::vec3((i & 1 ? high_ : low_).x, (i & 2 ? high_ : low_).y, (i & 4 ? high_ : low_).z),
          VertexKind::kCorner, kNoPoint);
    }
  }
  // Returns false and adds nothing if the point is outside or within a thousandth of the side of a
  // face, where it would only make slivers.
  bool Add(const glm::dvec3& point, VertexKind kind, uint32_t source = kNoPoint) {
    const glm::vec3 p(point), margin = 1e-3f * (high_ - low_);
    if (!glm::all(glm::greaterThan(p, low_ + margin)) ||
        !glm::all(glm::lessThan(p, high_ - margin))) {
      return false;
    }
    Append(p, kind, source);
    return true;
  }
  StartPoints Take() { return std::move(points_); }

 private:
  void Append(const glm::vec3& p, VertexKind kind, uint32_t source) {
    points_.positions.push_back(p);
    points_.kinds.push_back(kind);
    points_.point.push_back(source);
  }

  glm::vec3 low_, high_;
  StartPoints points_;
};

// The ratio of the radii of successive spheres in the thin part of the fill. Each sphere slows down
// all rays that nothing stops before it.
constexpr double kFarFactor = 4;

// Share of the cell's half side by which vertices are jittered. Below 1, so that no two vertices
// come arbitrarily close.
constexpr double kJitter = 0.8;

// Unit vectors that cover the sphere evenly (a golden-angle spiral).
std::vector<glm::dvec3> FibonacciSphere(int count) {
  std::vector<glm::dvec3> directions;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count;
    const double r = std::sqrt(1 - z * z), angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
    directions.emplace_back(r * std::cos(angle), r * std::sin(angle), z);
  }
  return directions;
}

template <class Visit>
void ForEachNeighborOffset(Visit&& visit) {
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) visit(glm::ivec3(x, y, z));
    }
  }
}

bool HasEmptyFaceNeighbor(const OccupancyGrid& grid, const glm::ivec3& cell) {
  for (int axis = 0; axis < 3; ++axis) {
    for (int step : {-1, 1}) {
      glm::ivec3 neighbor = cell;
      neighbor[axis] += step;
      if (!grid.Inside(neighbor)) return true;
    }
  }
  return false;
}

// True for inside cells and their neighbours.
bool IsNearInside(const OccupancyGrid& grid, const glm::ivec3& cell) {
  bool found = false;
  ForEachNeighborOffset([&](const glm::ivec3& offset) { found |= grid.Inside(cell + offset); });
  return found;
}

glm::dvec3 Jittered(const OccupancyGrid& grid, const glm::ivec3& cell, MersenneRandom& random) {
  return grid.CellCenter(cell.x, cell.y, cell.z) +
         0.5 * kJitter * grid.CellSize() * RandomInCube(random);
}

}  // namespace

StartPoints StartFromCarve(const OccupancyGrid& grid, const CarveStartOptions& options,
                           uint64_t seed) {
  const Bounds3 carved = grid.InsideBounds();
  if (carved.IsEmpty()) {
    throw DataError(fmt::format(
        "carving left none of {}x{}x{} cells: the alpha masks do not agree on a subject inside the "
        "scene's bounds",
        grid.size.x, grid.size.y, grid.size.z));
  }
  // Leaves room for the cells beside the surface, also around a thin subject.
  const Bounds3 grown = carved.Scaled(options.box_growth);
  const glm::dvec3 room = 1.5 * grid.CellSize();
  const Bounds3 box{glm::min(grown.min, carved.min - room), glm::max(grown.max, carved.max + room)};

  MersenneRandom random(seed);
  BoxPoints points(box);
  for (int z = -1; z <= grid.size.z; ++z) {
    for (int y = -1; y <= grid.size.y; ++y) {
      for (int x = -1; x <= grid.size.x; ++x) {
        const glm::ivec3 cell(x, y, z);
        if (grid.Inside(cell)) {
          if (HasEmptyFaceNeighbor(grid, cell)) {
            points.Add(Jittered(grid, cell, random), VertexKind::kSurface);
          } else if (random.Uniform() < options.inner_share) {
            points.Add(Jittered(grid, cell, random), VertexKind::kInner);
          }
        } else if (IsNearInside(grid, cell) && random.Uniform() < options.near_share) {
          points.Add(Jittered(grid, cell, random), VertexKind::kNear);
        }
      }
    }
  }
  // The number of tries is bounded because a subject may fill its box.
  for (int added = 0, tries = 0; added < options.outer_points && tries < 100 * options.outer_points;
       ++tries) {
    const glm::dvec3 p = box.Center() + 0.5 * box.Size() * RandomInCube(random);
    if (!IsNearInside(grid, grid.CellOf(p)) && points.Add(p, VertexKind::kOuter)) ++added;
  }
  return points.Take();
}

StartPoints StartFromGrid(const Bounds3& box, int cells, uint64_t seed) {
  OccupancyGrid grid{box, CubicCells(box, cells), {}};
  MersenneRandom random(seed);
  BoxPoints points(box);
  for (int z = 0; z < grid.size.z; ++z) {
    for (int y = 0; y < grid.size.y; ++y) {
      for (int x = 0; x < grid.size.x; ++x) {
        points.Add(Jittered(grid, {x, y, z}, random), VertexKind::kInner);
      }
    }
  }
  return points.Take();
}

FilteredPoints FilterPoints(std::span<const SparsePoint> points, const PointFilter& filter) {
  FilteredPoints result;
  std::vector<uint32_t> good;
  for (size_t i = 0; i < points.size(); ++i) {
    const SparsePoint& p = points[i];
    const bool finite = std::isfinite(p.position.x) && std::isfinite(p.position.y) &&
                        std::isfinite(p.position.z) && std::isfinite(p.reprojection_error_px);
    if (!finite) {
      ++result.not_finite;
    } else if (p.reprojection_error_px > filter.max_reprojection_error_px) {
      ++result.high_error;
    } else if (p.track_length < filter.min_track_length) {
      ++result.short_track;
    } else {
      good.push_back(uint32_t(i));
    }
  }
  std::sort(good.begin(), good.end(), [&](uint32_t a, uint32_t b) {
    return std::tuple(-int64_t{points[a].track_length}, points[a].reprojection_error_px, a) <
           std::tuple(-int64_t{points[b].track_length}, points[b].reprojection_error_px, b);
  });
  if (filter.min_spacing <= 0) {
    result.kept = std::move(good);
    std::sort(result.kept.begin(), result.kept.end());
    return result;
  }

  // Cells are as large as the spacing, so a closer point is in the same or a neighbouring cell.
  const auto cell_of = [&](const glm::dvec3& p) { return glm::floor(p / filter.min_spacing); };
  const auto hash = [](const glm::dvec3& cell) {
    return std::hash<double>()(cell.x) * 73856093u ^ std::hash<double>()(cell.y) * 19349663u ^
           std::hash<double>()(cell.z) * 83492791u;
  };
  std::unordered_map<glm::dvec3, std::vector<uint32_t>, decltype(hash)> cells(good.size(), hash);
  for (const uint32_t i : good) {
    const glm::dvec3 cell = cell_of(points[i].position);
    bool is_close = false;
    ForEachNeighborOffset([&](const glm::ivec3& offset) {
      const auto found = cells.find(cell + glm::dvec3(offset));
      if (is_close || found == cells.end()) return;
      for (const uint32_t j : found->second) {
        is_close |= glm::distance(points[i].position, points[j].position) < filter.min_spacing;
      }
    });
    if (is_close) {
      ++result.too_close;
    } else {
      cells[cell].push_back(i);
      result.kept.push_back(i);
    }
  }
  std::sort(result.kept.begin(), result.kept.end());
  return result;
}

PointStart StartFromPoints(std::span<const glm::dvec3> positions,
                           std::span<const glm::dvec3> cameras_in_world, const Bounds3& subject,
                           const PointStartOptions& options, uint64_t seed) {
  if (cameras_in_world.empty())
    throw DataError("the scene has no camera, so its extent is unknown");
  if (subject.IsEmpty() || !(subject.Diagonal() > 0)) {
    throw DataError("the scene's subject bounds are empty");
  }
  const glm::dvec3 center = subject.Center();
  const double subject_radius = 0.5 * subject.Diagonal();
  double camera_radius = subject_radius;
  for (const glm::dvec3& c : cameras_in_world) {
    camera_radius = std::max(camera_radius, glm::distance(c, center));
  }
  double needed = 0;
  if (!positions.empty()) {
    std::vector<double> distances;
    for (const glm::dvec3& p : positions) distances.push_back(glm::distance(p, center));
    needed = 1.05 * Quantile(std::move(distances), options.far_share);
  }
  PointStart result;
  const double fill_radius = std::clamp(needed, options.min_fill_over_camera * camera_radius,
                                        options.max_fill_over_camera * camera_radius);
  result.far_radius = std::max(fill_radius, options.far_over_camera * camera_radius);
  const double half_side = options.box_over_shell * result.far_radius;

  MersenneRandom random(seed);
  BoxPoints points({center - half_side, center + half_side});
  for (size_t i = 0; i < positions.size(); ++i) {
    const bool is_near = glm::distance(positions[i], center) < 0.98 * result.far_radius;
    if (!is_near || !points.Add(positions[i], VertexKind::kSurface, uint32_t(i))) {
      ++result.dropped_far;
    }
  }

  // Distance between vertices on a sphere, between spheres and between inner cells, in radii.
  const double spacing = std::sqrt(4 * std::numbers::pi / options.sphere_points);
  const int cells = int(std::ceil(2 / spacing));
  const OccupancyGrid inner{
      {center - subject_radius, center + subject_radius}, glm::ivec3(cells), {}};
  for (int z = 0; z < cells; ++z) {
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        const glm::dvec3 p = Jittered(inner, {x, y, z}, random);
        if (glm::distance(p, center) > subject_radius) continue;
        result.fill += points.Add(p, subject.Contains(p) ? VertexKind::kInner : VertexKind::kOuter);
      }
    }
  }
  const std::vector<glm::dvec3> directions = FibonacciSphere(options.sphere_points);
  // From `inner_radius` to below `outer_radius`; each sphere is about `factor` times as large as
  // the one before.
  const auto add_spheres = [&](double inner_radius, double outer_radius, double factor) {
    const double growth = std::log(outer_radius / inner_radius);
    const int steps = std::max(1, int(std::lround(growth / std::log(factor))));
    for (int k = 0; k < steps; ++k) {
      const glm::dmat3 turn = glm::mat3_cast(RandomQuaternion(random));
      for (const glm::dvec3& direction : directions) {
        const double step = k + 0.5 * kJitter * (2 * random.Uniform() - 1);
        const double radius = inner_radius * std::exp(growth * std::max(0.0, step) / steps);
        result.fill += points.Add(center + radius * (turn * direction), VertexKind::kOuter);
      }
    }
  };
  add_spheres(subject_radius, fill_radius, 1 + 1.5 * spacing);
  if (result.far_radius > fill_radius) add_spheres(fill_radius, result.far_radius, kFarFactor);
  for (const glm::dvec3& direction : FibonacciSphere(2 * options.sphere_points)) {
    result.fill += points.Add(center + result.far_radius * direction, VertexKind::kFar);
  }
  result.points = points.Take();
  return result;
}

}  // namespace tetrec
