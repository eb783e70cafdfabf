// Area sampling, nearest triangles, accuracy, completeness and F-score.
#include "eval/mesh_metrics.h"

#include "core/error.h"
#include "core/parallel.h"
#include "core/random.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nanoflann.hpp>

namespace tetrec {
namespace {

constexpr double kCropGrowth = 0.05;  // share of the sides of the truth's bounding box
constexpr size_t kNearestSamples = 16;

struct Triangle {
  glm::dvec3 a, b, c;
  double Area() const { return 0.5 * glm::length(glm::cross(b - a, c - a)); }
};

Triangle TriangleOf(const TriangleMesh& mesh, size_t index) {
  const glm::uvec3 ids = mesh.triangles[index];
  return {glm::dvec3(mesh.positions[ids[0]]), glm::dvec3(mesh.positions[ids[1]]),
          glm::dvec3(mesh.positions[ids[2]])};
}

double SegmentDistance(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 along = b - a;
  const double squared = glm::dot(along, along);
  const double t = squared > 0 ? std::clamp(glm::dot(p - a, along) / squared, 0.0, 1.0) : 0.0;
  return glm::length(p - (a + t * along));
}

// Distance to the plane if the foot of the perpendicular is inside the triangle, otherwise to the
// nearest edge.
double TriangleDistance(const glm::dvec3& p, const Triangle& t) {
  const glm::dvec3 normal = glm::cross(t.b - t.a, t.c - t.a);
  const double squared = glm::dot(normal, normal);
  const bool inside = squared > 0 && glm::dot(glm::cross(t.b - t.a, p - t.a), normal) >= 0 &&
                      glm::dot(glm::cross(t.c - t.b, p - t.b), normal) >= 0 &&
                      glm::dot(glm::cross(t.a - t.c, p - t.c), normal) >= 0;
  if (inside) return std::abs(glm::dot(p - t.a, normal)) / std::sqrt(squared);
  return std::min(
      {SegmentDistance(p, t.a, t.b), SegmentDistance(p, t.b, t.c), SegmentDistance(p, t.c, t.a)});
}

// The interface through which nanoflann reads points.
struct PointCloud {
  std::vector<glm::dvec3> points;
  size_t kdtree_get_point_count() const { return points.size(); }
  double kdtree_get_pt(size_t index, size_t axis) const { return points[index][int(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, PointCloud>,
                                                   PointCloud, 3>;

// The triangles whose bounding boxes meet `box`.
TriangleMesh TrianglesNear(const TriangleMesh& mesh, const Bounds3& box) {
  TriangleMesh near{mesh.positions, {}, {}};
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = TriangleOf(mesh, i);
    const glm::dvec3 low = glm::min(t.a, glm::min(t.b, t.c)),
                     high = glm::max(t.a, glm::max(t.b, t.c));
    const bool apart = low.x > box.max.x || low.y > box.max.y || low.z > box.max.z ||
                       high.x < box.min.x || high.y < box.min.y || high.z < box.min.z;
    if (!apart) near.triangles.push_back(mesh.triangles[i]);
  }
  return near;
}

double Area(const TriangleMesh& mesh) {
  double area = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) area += TriangleOf(mesh, i).Area();
  return area;
}

// 0 for a triangle without area.
glm::dvec3 NormalOf(const TriangleMesh& mesh, size_t index) {
  const Triangle t = TriangleOf(mesh, index);
  const glm::dvec3 normal = glm::cross(t.b - t.a, t.c - t.a);
  const double length = glm::length(normal);
  return length > 0 ? normal / length : normal;
}

struct OrientedSamples {
  std::vector<glm::dvec3> positions, normals;
};

// The box grows along a thin side as along those of a cube of its diagonal; otherwise hardly
// anything would be inside the box of a relief, and nothing inside that of a flat truth.
Bounds3 DefaultCrop(const Bounds3& truth) {
  const glm::dvec3 sides = glm::max(truth.Size(), glm::dvec3(truth.Diagonal() / std::sqrt(3.0)));
  const glm::dvec3 margin = 0.5 * kCropGrowth * sides;
  return {truth.min - margin, truth.max + margin};
}

OrientedSamples SamplesInside(const TriangleMesh& mesh, const Bounds3& box,
                              const SurfaceScoreOptions& options, uint64_t seed) {
  const TriangleMesh near = TrianglesNear(mesh, box);
  if (!(Area(near) > 0)) return {};
  const SurfaceSamples all = SampleSurface(near, options.samples, seed);
  OrientedSamples inside;
  for (size_t i = 0; i < all.positions.size(); ++i) {
    if (!box.Contains(all.positions[i])) continue;
    inside.positions.push_back(all.positions[i]);
    inside.normals.push_back(NormalOf(near, all.triangles[i]));
  }
  return inside;
}

// How samples of one surface lie to the other surface.
struct Comparison {
  std::vector<double> distances;
  std::vector<double> angles_deg;  // between normals
};

Comparison Compare(const OrientedSamples& samples, const TriangleMesh& surface,
                   const SurfaceScoreOptions& options, uint64_t seed) {
  Comparison result;
  const std::vector<NearestTriangle> nearest =
      NearestTriangles(samples.positions, surface, options.samples, seed);
  for (size_t i = 0; i < nearest.size(); ++i) {
    const double cosine = glm::dot(samples.normals[i], NormalOf(surface, nearest[i].triangle));
    result.distances.push_back(nearest[i].distance);
    result.angles_deg.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI);
  }
  return result;
}

double Mean(std::span<const double> values) {
  double sum = 0;
  for (double value : values) sum += value;
  return sum / double(values.size());
}

double ShareBelow(std::span<const double> values, double limit) {
  const auto below =
      std::count_if(values.begin(), values.end(), [&](double v) { return v < limit; });
  return double(below) / double(values.size());
}

std::optional<double> MeanAngle(const Comparison& comparison, double threshold) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < comparison.distances.size(); ++i) {
    if (comparison.distances[i] >= threshold) continue;
    sum += comparison.angles_deg[i];
    ++count;
  }
  return count > 0 ? std::optional(sum / count) : std::nullopt;
}

ScoresAtDistance ScoreAt(double threshold, const Comparison& to_truth,
                         const Comparison& to_reconstruction) {
  ScoresAtDistance scores{threshold, ShareBelow(to_truth.distances, threshold),
                          ShareBelow(to_reconstruction.distances, threshold), 0};
  const double sum = scores.precision + scores.recall;
  scores.f_score = sum > 0 ? 2 * scores.precision * scores.recall / sum : 0;
  return scores;
}

}  // namespace

SurfaceSamples SampleSurface(const TriangleMesh& mesh, size_t count, uint64_t seed) {
  std::vector<double> area_up_to;
  area_up_to.reserve(mesh.triangles.size());
  double area = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    area_up_to.push_back(area += TriangleOf(mesh, i).Area());
  }
  if (!(area > 0) || !std::isfinite(area)) {
    throw DataError(fmt::format("mesh of {} triangles has area {:g}; it cannot be sampled",
                                mesh.triangles.size(), area));
  }
  MersenneRandom random(seed);
  SurfaceSamples samples;
  samples.positions.reserve(count);
  samples.triangles.reserve(count);
  for (size_t i = 0; i < count; ++i) {
    // Stratified over the area: one sample in each of `count` equal shares.
    const double target = area * (double(i) + random.Uniform()) / double(count);
    const auto it = std::upper_bound(area_up_to.begin(), area_up_to.end(), target);
    const size_t index = std::min(size_t(it - area_up_to.begin()), mesh.triangles.size() - 1);
    const Triangle t = TriangleOf(mesh, index);
    const double root = std::sqrt(random.Uniform()), v = random.Uniform();
    samples.positions.push_back((1 - root) * t.a + root * (1 - v) * t.b + root * v * t.c);
    samples.triangles.push_back(uint32_t(index));
  }
  return samples;
}

std::vector<NearestTriangle> NearestTriangles(std::span<const glm::dvec3> points,
                                              const TriangleMesh& mesh, size_t samples,
                                              uint64_t seed) {
  SurfaceSamples on_surface = SampleSurface(mesh, samples, seed);
  PointCloud cloud{std::move(on_surface.positions)};
  std::vector<uint32_t> triangle_of = std::move(on_surface.triangles);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Triangle t = TriangleOf(mesh, i);
    cloud.points.push_back((t.a + t.b + t.c) / 3.0);
    triangle_of.push_back(uint32_t(i));
  }
  const KdTree tree(3, cloud, nanoflann::KDTreeSingleIndexAdaptorParams(16));

  std::vector<NearestTriangle> result(points.size());
  ParallelFor(points.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      uint32_t nearest[kNearestSamples];
      double squared[kNearestSamples];
      const size_t found = tree.knnSearch(&points[i].x, kNearestSamples, nearest, squared);
      NearestTriangle best{std::numeric_limits<double>::infinity(), 0};
      for (size_t k = 0; k < found; ++k) {
        const uint32_t triangle = triangle_of[nearest[k]];
        const double distance = TriangleDistance(points[i], TriangleOf(mesh, triangle));
        if (distance < best.distance) best = {distance, triangle};
      }
      result[i] = best;
    }
  });
  return result;
}

SurfaceScores CompareSurfaces(const TriangleMesh& reconstruction, const TriangleMesh& truth,
                              const SurfaceScoreOptions& options) {
  Bounds3 truth_bounds;
  for (const glm::uvec3& triangle : truth.triangles) {
    for (int i = 0; i < 3; ++i) truth_bounds.Add(glm::dvec3(truth.positions[triangle[i]]));
  }
  SurfaceScores scores;
  scores.crop = options.bounds ? *options.bounds : DefaultCrop(truth_bounds);
  const Bounds3 judged{glm::max(truth_bounds.min, scores.crop.min),
                       glm::min(truth_bounds.max, scores.crop.max)};
  const OrientedSamples truth_samples = SamplesInside(truth, scores.crop, options, options.seed);
  if (judged.IsEmpty() || truth_samples.positions.empty()) {
    throw DataError(
        fmt::format("the ground-truth mesh ({} triangles) has no surface inside the bounds",
                    truth.triangles.size()));
  }
  scores.diagonal = judged.Diagonal();
  scores.threshold = options.threshold * scores.diagonal;
  scores.truth_samples = truth_samples.positions.size();

  const OrientedSamples samples =
      SamplesInside(reconstruction, scores.crop, options, options.seed + 1);
  scores.reconstruction_samples = samples.positions.size();
  if (samples.positions.empty()) {
    for (const double share : kThresholdShares) {
      scores.at_distances.push_back({share * scores.threshold, 0, 0, 0});
    }
    return scores;
  }

  // The surfaces that distances are measured to extend beyond the box, so that its walls do not cut
  // off the nearest point.
  const glm::dvec3 margin(0.1 * scores.diagonal);
  const Bounds3 wide{scores.crop.min - margin, scores.crop.max + margin};
  const Comparison to_truth =
      Compare(samples, TrianglesNear(truth, wide), options, options.seed + 2);
  const Comparison to_reconstruction =
      Compare(truth_samples, TrianglesNear(reconstruction, wide), options, options.seed + 3);
  scores.accuracy = Mean(to_truth.distances);
  scores.completeness = Mean(to_reconstruction.distances);
  scores.chamfer = 0.5 * (*scores.accuracy + *scores.completeness);
  for (const double share : kThresholdShares) {
    scores.at_distances.push_back(ScoreAt(share * scores.threshold, to_truth, to_reconstruction));
  }
  const ScoresAtDistance at = ScoreAt(scores.threshold, to_truth, to_reconstruction);
  scores.precision = at.precision;
  scores.recall = at.recall;
  scores.f_score = at.f_score;
  const auto forth = MeanAngle(to_truth, scores.threshold),
             back = MeanAngle(to_reconstruction, scores.threshold);
  if (forth && back) scores.normal_angle_deg = 0.5 * (*forth + *back);
  return scores;
}

}  // namespace tetrec
